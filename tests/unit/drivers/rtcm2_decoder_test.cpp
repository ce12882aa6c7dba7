#include "drivers/rtcm2_decoder.hpp"

#include <gtest/gtest.h>

#include <map>

#include "corrections_data.hpp"
#include "drivers/rtcm2_encoder.hpp"

namespace kawara::drivers {
namespace {

using testing::Append;
using testing::Bytes;
using testing::ReadRecording;

std::vector<Rtcm2Message> Decode(const Bytes& stream, std::size_t longest = SIZE_MAX / 2,
                                 Rtcm2Decoder::Stats* stats = nullptr) {
  std::vector<Rtcm2Message> messages;
  Rtcm2Decoder decoder;
  testing::ForPieces(stream, longest, [&](std::span<const std::uint8_t> piece) {
    while (const Rtcm2Message* m = decoder.Next(piece)) messages.push_back(*m);
    EXPECT_TRUE(piece.empty());
  });
  if (stats != nullptr) *stats = decoder.stats();
  return messages;
}

bool Same(const Rtcm2Message& a, const Rtcm2Message& b) {
  return a.type == b.type && a.station == b.station && a.time_of_hour == b.time_of_hour &&
         a.sequence == b.sequence && a.health == b.health && a.data_words == b.data_words &&
         a.data == b.data;
}
bool Same(const std::vector<Rtcm2Message>& a, const std::vector<Rtcm2Message>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return Same(x, y); });
}

/// The same bits `shift` bits later (0..5), in the 6-of-8 form.
Bytes ShiftBits(const Bytes& stream, unsigned shift) {
  std::vector<bool> bits(shift, true);
  for (const std::uint8_t byte : stream) {
    if ((byte & 0xC0) != 0x40) continue;
    for (unsigned i = 0; i < 6; ++i) bits.push_back(((byte >> i) & 1U) != 0);
  }
  while (bits.size() % 6 != 0) bits.push_back(false);
  Bytes shifted(bits.size() / 6, 0x40);
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (bits[i]) shifted[i / 6] = static_cast<std::uint8_t>(shifted[i / 6] | (1U << (i % 6)));
  }
  return shifted;
}

/// Messages of one station, one a second; a parity chain through all of them.
Bytes MakeStream(const std::vector<Rtcm2Message>& messages) {
  Rtcm2Encoder encoder;
  Bytes stream;
  for (const auto& m : messages) Append(stream, encoder.Encode(m));
  return stream;
}
Rtcm2Message MakeMessage(int type, int station, int z_count, int words) {
  Rtcm2Message m;
  m.type = static_cast<std::uint8_t>(type);
  m.station = static_cast<std::uint16_t>(station);
  m.time_of_hour = z_count * std::chrono::milliseconds(600);
  m.data_words = static_cast<std::uint8_t>(words);
  for (std::size_t i = 0; i < m.data_words; ++i) m.data[i] = (0x123457U * (i + 1)) & 0xFFFFFFU;
  return m;
}

TEST(Rtcm2Decoder, TypesOfTheRecording) {
  Rtcm2Decoder::Stats stats;
  std::map<int, int> types;
  for (const auto& m : Decode(ReadRecording("testglo.rtcm2"), 1000, &stats)) {
    ++types[m.type];
    EXPECT_FALSE(m.malformed) << static_cast<int>(m.type);
    EXPECT_EQ(m.station, 0);
  }
  EXPECT_EQ(types, (std::map<int, int>{{1, 185}, {3, 18}, {18, 744}, {19, 744}, {22, 36}}));
  EXPECT_EQ(stats.messages, 1727U);
  EXPECT_EQ(stats.parity_errors, 0U);
  EXPECT_EQ(stats.locks, 1U);
  EXPECT_EQ(stats.unconfirmed, 0U);
}

TEST(Rtcm2Decoder, BasePositionOfTheRecording) {
  // The same base as testglo.rtcm3: message 3 in centimetres, 22 adds the rest.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  int checked = 0;
  for (const auto& m : Decode(ReadRecording("testglo.rtcm2"))) {
    if (const auto* s = std::get_if<Rtcm2Station>(&m.body)) centre_m = s->ecef_m;
    const auto* offset = std::get_if<Rtcm2StationOffset>(&m.body);
    if (offset == nullptr || centre_m.isZero()) continue;
    const Eigen::Vector3d ecef_m = centre_m + offset->l1_m;
    const Eigen::Vector3d expected_m(-3869297.5138, 3436571.3345, 3717369.3757);
    EXPECT_LT((ecef_m - expected_m).norm(), 0.0001);
    ++checked;
  }
  EXPECT_GE(checked, 34);
}

TEST(Rtcm2Decoder, ObservationsOfTheRecordingComeInPairs) {
  // 18 and 19 of one band and system carry the same satellites at the same time.
  const auto messages = Decode(ReadRecording("testglo.rtcm2"));
  int pairs = 0;
  for (std::size_t i = 0; i + 1 < messages.size(); ++i) {
    if (messages[i].type != 18 || messages[i + 1].type != 19) continue;
    const auto& phase = std::get<Rtcm2Observations>(messages[i].body);
    const auto& range = std::get<Rtcm2Observations>(messages[i + 1].body);
    EXPECT_EQ(phase.gps_mask, range.gps_mask);
    EXPECT_EQ(phase.glonass_mask, range.glonass_mask);
    EXPECT_EQ(phase.band, range.band);
    EXPECT_EQ(phase.count, (messages[i].data_words - 1) / 2);
    EXPECT_EQ(Rtcm2TimeOfHour(messages[i]), Rtcm2TimeOfHour(messages[i + 1]));
    ++pairs;
  }
  EXPECT_EQ(pairs, 744);
}

TEST(Rtcm2Decoder, AnySplitGivesTheSameMessages) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Rtcm2Decoder::Stats whole_stats;
  const auto whole = Decode(stream, SIZE_MAX / 2, &whole_stats);
  for (const std::size_t longest : {1U, 2U, 5U, 33U, 1000U}) {
    Rtcm2Decoder::Stats stats;
    const auto pieces = Decode(stream, longest, &stats);
    ASSERT_TRUE(Same(pieces, whole)) << longest;
    EXPECT_EQ(stats.message_bytes, whole_stats.message_bytes);
    for (std::size_t i = 0; i < whole.size(); ++i) {
      ASSERT_EQ(pieces[i].stream_end, whole[i].stream_end);
      ASSERT_EQ(pieces[i].stream_bytes, whole[i].stream_bytes);
    }
  }
}

TEST(Rtcm2Decoder, ByteByByteIsTheSame) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Rtcm2Decoder decoder;
  std::vector<Rtcm2Message> messages;
  for (const std::uint8_t byte : stream) {
    if (auto m = decoder.Feed(byte)) messages.push_back(*m);
  }
  EXPECT_TRUE(Same(messages, Decode(stream)));
}

TEST(Rtcm2Decoder, AnyBitAlignment) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  const auto aligned = Decode(stream);
  for (unsigned shift = 1; shift < 6; ++shift) {
    const auto shifted = Decode(ShiftBits(stream, shift));
    EXPECT_TRUE(Same(shifted, aligned)) << shift;
  }
}

TEST(Rtcm2Decoder, StreamRangesCoverTheMessagesAndDoNotOverlap) {
  for (unsigned shift : {0U, 4U}) {
    const Bytes stream = ShiftBits(ReadRecording("testglo.rtcm2"), shift);
    std::uint64_t end = 0;
    for (const auto& m : Decode(stream, 77)) {
      const std::uint64_t begin = m.stream_end - m.stream_bytes;
      EXPECT_GE(begin, end);
      const std::size_t words = m.data_words + 2U;
      EXPECT_GE(m.stream_bytes, words * 5U);
      EXPECT_LE(m.stream_bytes, words * 5U + 1U);
      end = m.stream_end;
    }
    EXPECT_LE(end, stream.size());
  }
}

TEST(Rtcm2Decoder, OneWrongBitCostsAtMostTwoMessages) {
  // The message it hits, and, if it hits the last two bits of a message, the next one's parity too.
  const Bytes stream = ReadRecording("testglo.rtcm2");
  for (std::size_t at = 3000; at < stream.size(); at += 10'009) {
    Bytes damaged = stream;
    damaged[at] ^= 0x04;
    const auto messages = Decode(damaged);
    EXPECT_GE(messages.size(), 1725U) << at;
  }
}

TEST(Rtcm2Decoder, LostBytesCostFewMessages) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  for (std::size_t at = 3000; at + 100 < stream.size(); at += 25'003) {
    for (const std::ptrdiff_t lost : {1, 7, 60}) {
      Bytes damaged = stream;
      const auto first = damaged.begin() + static_cast<std::ptrdiff_t>(at);
      damaged.erase(first, first + lost);
      EXPECT_GE(Decode(damaged).size(), 1724U) << at << " " << lost;
    }
  }
}

TEST(Rtcm2Decoder, ForeignBytesBetweenAreSkipped) {
  // CR, LF, zeros and text without 01xxxxxx between all bytes change nothing.
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Bytes mixed;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    mixed.push_back(stream[i]);
    if (i % 11 == 0) Append(mixed, Bytes{0x0D, 0x0A, 0x00, 0xD3, 0x24});
  }
  EXPECT_TRUE(Same(Decode(mixed), Decode(stream)));
}

TEST(Rtcm2Decoder, TextInTheMiddleCostsFewMessages) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Bytes mixed(stream.begin(), stream.begin() + 50000);
  Append(mixed, testing::AsBytes("$GPGGA,JUST SOME TEXT IN CAPITALS*7F\r\n[USB1]<OK"));
  mixed.insert(mixed.end(), stream.begin() + 50000, stream.end());
  EXPECT_GE(Decode(mixed).size(), 1725U);
}

TEST(Rtcm2Decoder, FirstMessageCountsOnceTheSecondFits) {
  const Bytes stream = MakeStream({MakeMessage(18, 5, 100, 9), MakeMessage(19, 5, 101, 9)});
  Rtcm2Decoder decoder;
  std::vector<int> types;
  std::size_t fed = 0, first_out = 0;
  for (const std::uint8_t byte : stream) {
    ++fed;
    if (const auto m = decoder.Feed(byte)) {
      if (types.empty()) first_out = fed;
      types.push_back(m->type);
    }
  }
  EXPECT_EQ(types, (std::vector<int>{18, 19}));
  EXPECT_EQ(first_out, 55U + 10U) << "with the header of the second";
  EXPECT_TRUE(decoder.locked());
}

TEST(Rtcm2Decoder, EmptyMessagesComeTwoAtOnce) {
  const Bytes stream =
      MakeStream({MakeMessage(6, 5, 100, 0), MakeMessage(6, 5, 101, 0), MakeMessage(6, 5, 102, 0)});
  EXPECT_EQ(Decode(stream).size(), 3U);
  Rtcm2Decoder decoder;
  int messages = 0;
  for (const std::uint8_t byte : stream) messages += decoder.Feed(byte) ? 1 : 0;
  EXPECT_EQ(messages, 3);
}

TEST(Rtcm2Decoder, LoneMessageIsNotBelieved) {
  Bytes stream = MakeStream({MakeMessage(18, 5, 100, 9)});
  stream.insert(stream.end(), 2000, 0x55);
  EXPECT_TRUE(Decode(stream).empty());
}

TEST(Rtcm2Decoder, TheSameMessageAgainProvesNothing) {
  // As in noise that repeats itself; a real base counts its messages.
  Bytes stream;
  for (int i = 0; i < 10; ++i) {
    Append(stream, MakeStream({MakeMessage(18, 5, 100, 9)}));
    stream.insert(stream.end(), 2000, 0x55);
  }
  EXPECT_TRUE(Decode(stream).empty());
}

TEST(Rtcm2Decoder, ConfirmationHasToComeSoon) {
  for (const std::size_t between : {60'000U, 70'000U}) {
    Bytes stream = MakeStream(
        {MakeMessage(18, 5, 100, 9), MakeMessage(19, 5, 101, 9), MakeMessage(18, 5, 102, 9)});
    stream.insert(stream.begin() + 55, between, 0x20);  // after the first message
    EXPECT_EQ(Decode(stream).size(), between < 65536 ? 3U : 2U);
  }
}

TEST(Rtcm2Decoder, WhatDoesNotFitIsNotBelieved) {
  struct Case {
    const char* what;
    Rtcm2Message second;
    std::size_t messages;
  };
  for (const Case& c : {Case{"same station, next second", MakeMessage(19, 5, 5999, 3), 2},
                        Case{"across the hour", MakeMessage(19, 5, 1, 3), 2},
                        Case{"GLONASS time, 18 s behind", MakeMessage(19, 5, 5968, 3), 2},
                        Case{"other station", MakeMessage(19, 6, 5999, 3), 0},
                        Case{"half an hour later", MakeMessage(19, 5, 3000, 3), 0}}) {
    EXPECT_EQ(Decode(MakeStream({MakeMessage(18, 5, 5998, 3), c.second})).size(), c.messages)
        << c.what;
  }
}

TEST(Rtcm2Decoder, NewStationHasToProveItself) {
  std::vector<Rtcm2Message> sent;
  for (int i = 0; i < 4; ++i) sent.push_back(MakeMessage(18, 5, 100 + i, 4));
  for (int i = 0; i < 4; ++i) sent.push_back(MakeMessage(18, 77, 104 + i, 4));
  EXPECT_TRUE(Same(Decode(MakeStream(sent)), sent));
}

TEST(Rtcm2Decoder, NoiseGivesNothing) {
  // All 16 MB carry bits: four times what plain noise would.
  Rtcm2Decoder decoder;
  std::uint64_t random = 88172645463325252ULL;
  Bytes block(1 << 16);
  for (int i = 0; i < 256; ++i) {
    for (auto& byte : block) {
      random ^= random << 13;
      random ^= random >> 7;
      random ^= random << 17;
      byte = static_cast<std::uint8_t>(0x40U | (random >> 58));
    }
    std::span<const std::uint8_t> rest(block);
    EXPECT_EQ(decoder.Next(rest), nullptr);
  }
  EXPECT_EQ(decoder.stats().bytes, 256U << 16);
}

TEST(Rtcm2Decoder, ResetForgets) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Rtcm2Decoder decoder;
  auto part = std::span<const std::uint8_t>(stream).first(5000);
  while (decoder.Next(part) != nullptr) {
  }
  EXPECT_TRUE(decoder.locked());
  decoder.Reset();
  EXPECT_FALSE(decoder.locked());
  part = std::span<const std::uint8_t>(stream).subspan(5000);
  std::uint64_t after = 0;
  while (decoder.Next(part) != nullptr) ++after;
  EXPECT_GE(after, 1700U);
}

TEST(Rtcm2Decoder, DoesNotAllocate) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Rtcm2Decoder decoder;
  const auto before = testing::AllocationsOfThisThread();
  std::span<const std::uint8_t> rest(stream);
  while (decoder.Next(rest) != nullptr) {
  }
  EXPECT_EQ(testing::AllocationsOfThisThread(), before);
}

TEST(Rtcm2Encoder, RecordingComesOutAsItWentIn) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Rtcm2Encoder encoder;
  Bytes again, original;
  for (const auto& m : Decode(stream)) {
    Append(again, encoder.Encode(m));
    const auto range = std::span(stream).subspan(m.stream_end - m.stream_bytes, m.stream_bytes);
    for (const std::uint8_t byte : range) {
      if ((byte & 0xC0) == 0x40) original.push_back(byte);
    }
  }
  EXPECT_EQ(again, original);
}

TEST(Rtcm2Encoder, AllFieldsSurvive) {
  std::vector<Rtcm2Message> sent;
  for (int i = 0; i < 70; ++i) {
    auto m = MakeMessage(1 + i % 64, 1023, 100 + i, i % 32);
    m.sequence = static_cast<std::uint8_t>(i % 8);
    m.health = static_cast<std::uint8_t>((i / 3) % 8);
    sent.push_back(m);
  }
  EXPECT_TRUE(Same(Decode(MakeStream(sent)), sent));
}

}  // namespace
}  // namespace kawara::drivers
