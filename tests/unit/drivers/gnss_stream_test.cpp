#include "drivers/gnss_stream.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "drivers/crc24q.hpp"
#include "tests/support/counting_allocator.hpp"
#include "tests/support/gnss_recording.hpp"

namespace kawara::drivers {
namespace {

using core::MonoTime;
using testing::Bytes;
using testing::Collector;
using testing::LoadRecording;
using testing::Sentence;
using testing::ToBytes;
using Stats = GnssStreamDecoder::Stats;

struct Decoded {
  std::vector<testing::Found> found;
  Stats stats;
  std::map<std::string, int> types;
};

/// Feeds pieces of the sizes that `next_size` gives.
template <class NextSize>
Decoded DecodeInPieces(const Bytes& bytes, NextSize next_size) {
  GnssStreamDecoder decoder;
  Collector sink;
  std::span<const std::uint8_t> rest(bytes);
  while (!rest.empty()) {
    const std::size_t n = std::min<std::size_t>(rest.size(), next_size());
    decoder.Feed(MonoTime::FromNs(7), rest.first(n), sink);
    rest = rest.subspan(n);
    const Stats& s = decoder.stats();
    EXPECT_EQ(s.good_bytes + s.bad_bytes + s.skipped_bytes + decoder.pending_bytes(),
              bytes.size() - rest.size());
  }
  decoder.Finish(sink);
  EXPECT_EQ(decoder.pending_bytes(), 0U);
  Decoded result{std::move(sink.found), decoder.stats(), {}};
  for (const testing::Found& f : result.found) ++result.types[f.type];
  return result;
}

Decoded Decode(const Bytes& bytes) {
  return DecodeInPieces(bytes, [&] { return bytes.size(); });
}

bool Same(const Stats& a, const Stats& b) {
  return a.good == b.good && a.bad_checksum == b.bad_checksum && a.invalid == b.invalid &&
         a.good_bytes == b.good_bytes && a.bad_bytes == b.bad_bytes &&
         a.skipped_bytes == b.skipped_bytes && a.rtcm2_parity_errors == b.rtcm2_parity_errors;
}

Bytes RandomBytes(std::size_t n, std::uint32_t seed) {
  std::mt19937 random(seed);
  Bytes bytes(n);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
  return bytes;
}

void Append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }
void Append(Bytes& to, const std::string& text) { Append(to, ToBytes(text)); }

const Bytes kRtcm1005{0xD3, 0x00, 0x13, 0x3E, 0xD7, 0xD3, 0x02, 0x02, 0x98, 0x0E, 0xDE, 0xEF, 0x34,
                      0xB4, 0xBD, 0x62, 0xAC, 0x09, 0x41, 0x98, 0x6F, 0x33, 0x36, 0x0B, 0x98};

TEST(GnssStream, RecordingsGiveWhatTheirOriginsSay) {
  struct Case {
    const char* name;
    std::map<std::string, int> types;
    std::uint64_t skipped;
  };
  const Case cases[] = {
      {"nmea-rtk.log", {{"GNGGA", 50}, {"GNRMC", 50}, {"GPGGA", 72}, {"GPRMC", 72}}, 0},
      {"ublox-rtk-fixed.nmea", {{"GNGGA", 120}, {"GNRMC", 120}}, 0},
      {"rtk_0759-3040_l1_ratio20.nmea", {{"GNGGA", 115}, {"GNRMC", 115}}, 0},
      {"ac12_binary.log",
       {{"GPGGA", 5},
        {"GPGSA", 5},
        {"GPGSV", 15},
        {"GPRMC", 5},
        {"GPZDA", 5},
        {"MCA", 12},
        {"PASHR", 13},
        {"PBN", 4}},
       0},
      {"ublox-zed-f9p-rtk.log",
       {{"UBX.01.01", 10},
        {"UBX.01.04", 10},
        {"UBX.01.07", 10},
        {"UBX.01.11", 10},
        {"UBX.01.20", 10},
        {"UBX.01.35", 10},
        {"UBX.01.61", 10}},
       0},
      {"rtcm3.log", {{"RTCM3.1005", 1}, {"RTCM3.1029", 1}}, 0},
      {"rtcm3-2.log",
       {{"RTCM3.1004", 83},
        {"RTCM3.1006", 8},
        {"RTCM3.1008", 8},
        {"RTCM3.1012", 84},
        {"RTCM3.1013", 8},
        {"RTCM3.1033", 8}},
       102},  // a frame that was cut off
      {"testglo.rtcm2",
       {{"RTCM2.1", 185}, {"RTCM2.3", 18}, {"RTCM2.18", 744}, {"RTCM2.19", 744}, {"RTCM2.22", 36}},
       2840},  // console text before it
  };
  for (const Case& c : cases) {
    const Bytes bytes = LoadRecording(c.name);
    ASSERT_FALSE(bytes.empty()) << c.name;
    const Decoded d = Decode(bytes);
    EXPECT_EQ(d.types, c.types) << c.name;
    EXPECT_EQ(d.stats.bad_checksum, 0U) << c.name;
    EXPECT_EQ(d.stats.invalid, 0U) << c.name;
    EXPECT_EQ(d.stats.skipped_bytes, c.skipped) << c.name;
  }
}

TEST(GnssStream, AnySplitGivesTheSame) {
  // All kinds of traffic after each other, with garbage between.
  Bytes all = RandomBytes(3000, 1);
  for (const char* name :
       {"ac12_binary.log", "ublox-zed-f9p-rtk.log", "rtcm3-2.log", "rtcm3.log"}) {
    const Bytes bytes = LoadRecording(name);
    Append(all, Bytes(bytes.begin(),
                      bytes.begin() +
                          static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size(), 6000))));
    Append(all, RandomBytes(500, 2));
  }
  const Bytes rtcm2 = LoadRecording("testglo.rtcm2");
  Append(all, Bytes(rtcm2.begin() + 2000, rtcm2.begin() + 8000));
  Append(all, LoadRecording("ublox-rtk-fixed.nmea"));
  const Decoded whole = Decode(all);
  ASSERT_GT(whole.stats.good, 300U);
  ASSERT_GT(whole.stats.skipped_bytes, 3000U);
  for (const std::size_t size : {1U, 2U, 3U, 7U, 64U, 1000U, 8191U, 8192U}) {
    const Decoded pieces = DecodeInPieces(all, [&] { return size; });
    EXPECT_EQ(pieces.found, whole.found) << size;
    EXPECT_TRUE(Same(pieces.stats, whole.stats)) << size;
  }
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const Decoded pieces = DecodeInPieces(all, [&] { return 1 + random() % 200; });
    EXPECT_EQ(pieces.found, whole.found);
    EXPECT_TRUE(Same(pieces.stats, whole.stats));
  }
}

TEST(GnssStream, EachMessageComesWithItsLastChecksumByte) {
  const Bytes bytes = LoadRecording("ac12_binary.log");
  GnssStreamDecoder decoder;
  std::uint64_t fed = 0;
  auto check = [&](const GnssMessage& m) { EXPECT_EQ(m.offset + m.bytes.size(), fed); };
  testing::Each sink(check);
  for (const std::uint8_t b : bytes) {
    ++fed;
    decoder.Feed(MonoTime::FromNs(1), {&b, 1}, sink);
  }
  EXPECT_EQ(decoder.stats().good, 64U);
}

TEST(GnssStream, ArrivalIsThatOfTheFirstByte) {
  const std::string a = Sentence("GPHDT,1.0,T");
  const Bytes bytes = ToBytes("noise" + a + Sentence("GPHDT,2.0,T"));
  GnssStreamDecoder decoder;
  Collector sink;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    decoder.Feed(MonoTime::FromNs(1000 + static_cast<std::int64_t>(i)), {&bytes[i], 1}, sink);
  ASSERT_EQ(sink.found.size(), 2U);
  EXPECT_EQ(sink.found[0].arrival_ns, 1005);
  EXPECT_EQ(sink.found[1].arrival_ns, 1005 + static_cast<std::int64_t>(a.size()));
}

TEST(GnssStream, ABadSentenceCostsItself) {
  std::string damaged = Sentence("GPHDT,2.0,T");
  damaged[7] = '3';
  const Decoded d = Decode(ToBytes(Sentence("GPHDT,1.0,T") + damaged + Sentence("GPHDT,4.0,T")));
  EXPECT_EQ(d.stats.good, 2U);
  EXPECT_EQ(d.stats.bad_checksum, 1U);
  EXPECT_EQ(d.stats.bad_bytes, damaged.size());
  EXPECT_EQ(d.stats.skipped_bytes, 0U);
}

TEST(GnssStream, GluedCutAndOverlongSentencesCostThemselves) {
  const std::string good = Sentence("GPHDT,1.0,T");
  const std::string overlong = "$GPTXT," + std::string(3000, 'x');
  for (const std::string& trouble :
       {std::string("$GPGGA,1234"), std::string("2.0,T*11\r\n"), overlong, std::string("$"),
        std::string("$GPGGA\r\n"), std::string("\xD3"), std::string("\xB5\x62"),
        std::string("\xD3\x03\xFF"), std::string("$PASHR,PBN,")}) {
    const Decoded d = Decode(ToBytes(good + trouble + good + trouble + good));
    EXPECT_EQ(d.stats.good, 3U) << trouble.substr(0, 20);
    EXPECT_EQ(d.stats.skipped_bytes + d.stats.bad_bytes, 2 * trouble.size())
        << trouble.substr(0, 20);
  }
}

TEST(GnssStream, EndsWithoutCrLfOrWithEitherAlone) {
  const std::string bare = "$PASHR,ACK*3D";
  const Decoded d = Decode(ToBytes(bare + bare + "\n" + bare + "\r" + bare + "\r\n" + bare));
  EXPECT_EQ(d.stats.good, 5U);
  EXPECT_EQ(d.stats.skipped_bytes, 0U);
}

TEST(GnssStream, AFalseBinaryHeaderDoesNotHoldBackText) {
  // 0xD3 0x03 0xFF claims 1029 bytes, 0xB5 0x62 .. 3000: the sentence behind must come out at once.
  for (const Bytes& lie : {Bytes{0xD3, 0x03, 0xFF}, Bytes{0xB5, 0x62, 0x01, 0x07, 0x00, 0x0B}}) {
    Bytes bytes = lie;
    Append(bytes, Sentence("GPHDT,1.0,T"));
    GnssStreamDecoder decoder;
    Collector sink;
    decoder.Feed(MonoTime::FromNs(1), bytes, sink);
    ASSERT_EQ(sink.found.size(), 1U);
    EXPECT_EQ(sink.found[0].offset, lie.size());
  }
}

TEST(GnssStream, PbnMayHoldAnything) {
  // Positions whose bytes are CR, LF, '$', 0xD3: valid by the word sum alone.
  Bytes structure(56, 0);
  const std::string inside = "\r\n$GPGGA,1*00\r\n\xD3";
  std::copy(inside.begin(), inside.end(), structure.begin() + 8);
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 54; i += 2)
    sum += static_cast<std::uint32_t>(structure[i]) << 8 | structure[i + 1];
  structure[54] = static_cast<std::uint8_t>(sum >> 8);
  structure[55] = static_cast<std::uint8_t>(sum);
  Bytes bytes = ToBytes("$PASHR,PBN,");
  Append(bytes, structure);
  Append(bytes, "\r\n" + Sentence("GPHDT,1.0,T"));
  const Decoded d = Decode(bytes);
  EXPECT_EQ(d.types.at("PBN"), 1);
  EXPECT_EQ(d.types.at("GPHDT"), 1);
  EXPECT_EQ(d.stats.invalid, 1U);  // no place on Earth
  EXPECT_EQ(d.stats.skipped_bytes + d.stats.bad_bytes, 0U);
}

TEST(GnssStream, ADamagedBinaryFrameCostsItself) {
  const Bytes bytes = LoadRecording("rtcm3-2.log");
  // The third frame of the recording, damaged in its middle.
  std::vector<testing::Found> frames;
  for (const testing::Found& f : Decode(bytes).found) frames.push_back(f);
  Bytes damaged = bytes;
  damaged[frames[2].offset + frames[2].bytes / 2] ^= 0x10;
  const Decoded d = Decode(damaged);
  EXPECT_EQ(d.stats.good, 198U);
  EXPECT_EQ(d.stats.bad_checksum, 1U);
  EXPECT_EQ(d.stats.bad_bytes, frames[2].bytes);
  EXPECT_EQ(d.stats.skipped_bytes, 102U);
}

TEST(GnssStream, GarbageInTheMiddleCostsOnlyWhatItHit) {
  for (const char* name : {"ac12_binary.log", "rtcm3-2.log", "ublox-zed-f9p-rtk.log"}) {
    const Bytes bytes = LoadRecording(name);
    const Decoded clean = Decode(bytes);
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      std::mt19937 random(seed);
      const std::size_t at = random() % bytes.size();
      Bytes dirty(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
      Append(dirty, RandomBytes(300, seed));
      Append(dirty, Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end()));
      const Decoded d = Decode(dirty);
      EXPECT_GE(d.stats.good + 1, clean.stats.good) << name << " " << at;
    }
  }
}

TEST(GnssStream, RandomBytesAreNotMessages) {
  const Bytes noise = RandomBytes(32U << 20, 4);
  GnssStreamDecoder decoder;
  Collector sink;
  decoder.Feed(MonoTime::FromNs(1), noise, sink);
  decoder.Finish(sink);
  EXPECT_EQ(decoder.stats().good, 0U);
  EXPECT_EQ(decoder.stats().skipped_bytes + decoder.stats().bad_bytes, noise.size());
}

TEST(GnssStream, RandomTextIsNotMessages) {
  std::mt19937 random(5);
  Bytes noise(8U << 20);
  constexpr std::string_view kLetters = "$$*,,.0123456789ABCDEFGP\r\n";
  for (std::uint8_t& b : noise) b = static_cast<std::uint8_t>(kLetters[random() % kLetters.size()]);
  const Decoded d = Decode(noise);
  // Sentence by shape are many of these; of them 1 in 256 has its checksum right, no more can be
  // known of unknown types.
  EXPECT_LT(d.stats.good, d.stats.bad_checksum / 100);
}

TEST(GnssStream, ReservedBitsOfRtcm3AreNoObstacle) {
  // The standard's frame with reserved bits set and its CRC made right again.
  Bytes frame = kRtcm1005;
  frame[1] = 0x54;
  const std::uint32_t crc = Crc24q(std::span(frame).first(frame.size() - 3));
  for (std::size_t i = 0; i < 3; ++i)
    frame[frame.size() - 3 + i] = static_cast<std::uint8_t>(crc >> (16 - 8 * i));
  Bytes bytes = ToBytes(Sentence("GPHDT,1.0,T"));
  Append(bytes, frame);
  Append(bytes, kRtcm1005);
  Append(bytes, RandomBytes(100, 6));
  Append(bytes, frame);
  EXPECT_EQ(Decode(bytes).types.at("RTCM3.1005"), 3);
}

TEST(GnssStream, Rtcm2BetweenSentences) {
  const Bytes rtcm2 = LoadRecording("testglo.rtcm2");
  Bytes mixed;
  int sentences = 0;
  for (std::size_t at = 2838; at < 60'000; at += 700) {
    Append(mixed, Bytes(rtcm2.begin() + static_cast<std::ptrdiff_t>(at),
                        rtcm2.begin() + static_cast<std::ptrdiff_t>(at + 700)));
    Append(mixed, Sentence("GPHDT,1.0,T"));
    ++sentences;
  }
  const Decoded alone = Decode(Bytes(rtcm2.begin() + 2838, rtcm2.begin() + 2838 + 700 * sentences));
  const Decoded d = Decode(mixed);
  EXPECT_EQ(d.types.at("GPHDT"), sentences);
  EXPECT_EQ(d.types.at("RTCM2.18"), alone.types.at("RTCM2.18"));
  EXPECT_EQ(d.types.at("RTCM2.19"), alone.types.at("RTCM2.19"));
}

TEST(GnssStream, NeverAllocates) {
  Bytes all;
  for (const char* name :
       {"ac12_binary.log", "ublox-zed-f9p-rtk.log", "rtcm3-2.log", "testglo.rtcm2", "nmea-rtk.log"})
    Append(all, LoadRecording(name));
  Append(all, RandomBytes(100'000, 7));
  GnssStreamDecoder decoder;
  std::uint64_t messages = 0;
  auto count = [&](const GnssMessage&) { ++messages; };
  testing::Each sink(count);
  const auto allocations = testing::CountAllocations([&] {
    std::span<const std::uint8_t> rest(all);
    while (!rest.empty()) {
      const std::size_t n = std::min<std::size_t>(rest.size(), 61);
      decoder.Feed(MonoTime::FromNs(1), rest.first(n), sink);
      rest = rest.subspan(n);
    }
    decoder.Finish(sink);
  });
  EXPECT_GT(messages, 2000U);
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace kawara::drivers
