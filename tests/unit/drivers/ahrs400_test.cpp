#include "drivers/ahrs400.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/counting_allocator.hpp"
#include "tests/unit/drivers/ahrs400_collector.hpp"

namespace kawara::drivers {
namespace {

using core::AhrsSample;
using core::MonoTime;
using testing::Append;
using testing::Bytes;
using testing::Collector;
using testing::Decode;
using ::testing::ElementsAre;
using testing::Frame;
using testing::kStart;
using testing::Packet;
using testing::Unit;
using testing::Version;

/// What a recording can hold: starts in the middle of a packet, replies, both lengths, damage,
/// garbage.
Bytes Mixture(std::uint32_t seed) {
  Unit unit(seed);
  Bytes bytes = unit.Angle();
  bytes.erase(bytes.begin(), bytes.begin() + 11);
  for (int i = 0; i < 20; ++i) Append(bytes, unit.Angle());
  Append(bytes, unit.Garbage(43));
  for (int i = 0; i < 5; ++i) Append(bytes, unit.Angle());
  Append(bytes, {'H'});
  Append(bytes, Version("AHRS400CC-100 v1.08"));
  Append(bytes, Frame({0x00, 0x0F, 0x42, 0x40}));
  Append(bytes, {'C'});
  for (int i = 0; i < 20; ++i) Append(bytes, unit.Scaled());
  Bytes damaged = unit.Scaled();
  damaged[7] ^= 0x10;
  Append(bytes, damaged);
  for (int i = 0; i < 4; ++i) Append(bytes, unit.Scaled());
  return bytes;
}

TEST(Ahrs400, AnySplitGivesTheSameResult) {
  const Bytes bytes = Mixture(1);
  Ahrs400Stats whole_stats;
  const Collector whole = Decode(bytes, 1U << 20, {}, &whole_stats);
  for (std::size_t step = 1; step < 70; ++step) {
    Ahrs400Stats stats;
    const Collector split = Decode(bytes, step, {}, &stats);
    ASSERT_EQ(split.Counters(), whole.Counters()) << step;
    for (std::size_t i = 0; i < whole.samples.size(); ++i) {
      ASSERT_EQ(split.samples[i].arrival, whole.samples[i].arrival) << step << ' ' << i;
      ASSERT_EQ(split.samples[i].sampled, whole.samples[i].sampled) << step << ' ' << i;
    }
    EXPECT_EQ(split.versions, whole.versions);
    EXPECT_EQ(split.serials, whole.serials);
    EXPECT_EQ(stats.skipped_bytes, whole_stats.skipped_bytes);
    EXPECT_EQ(stats.bad_checksum, whole_stats.bad_checksum);
    EXPECT_EQ(stats.packets, whole_stats.packets);
  }
}

TEST(Ahrs400, ArrivalIsTheFirstByteOnTheWire) {
  Unit unit(2);
  Bytes bytes = unit.Garbage(0);
  Append(bytes, {1, 2, 3});
  for (int i = 0; i < 3; ++i) Append(bytes, unit.Angle());
  const Ahrs400Config config;
  const Collector got = Decode(bytes, 7, config);
  ASSERT_EQ(got.samples.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(got.samples[i].arrival,
              kStart + static_cast<std::int64_t>(3 + 30 * i) * config.byte_time);
  }
}

TEST(Ahrs400, LockedPacketComesOutWithItsLastByte) {
  Unit unit(3);
  Ahrs400Decoder decoder;
  Collector sink;
  for (int i = 0; i < 3; ++i) decoder.Feed(kStart, unit.Angle(), sink);
  ASSERT_EQ(sink.samples.size(), 3U) << "the first two were held back until confirmed";
  const Bytes next = unit.Angle();
  decoder.Feed(kStart, std::span(next).first(29), sink);
  EXPECT_EQ(sink.samples.size(), 3U);
  decoder.Feed(kStart, std::span(next).last(1), sink);
  EXPECT_EQ(sink.samples.size(), 4U);
}

TEST(Ahrs400, MixtureGivesEveryWholePacket) {
  Ahrs400Stats stats;
  const Collector got = Decode(Mixture(4), 1U << 20, {}, &stats);
  EXPECT_EQ(stats.packets[0], 25U);
  EXPECT_EQ(stats.packets[1], 24U);
  EXPECT_EQ(stats.bad_checksum, 1U);
  EXPECT_THAT(got.versions, ElementsAre("AHRS400CC-100 v1.08     "));
  EXPECT_THAT(got.serials, ElementsAre(1'000'000U));
  EXPECT_EQ(stats.skipped_bytes, 19U + 43U + 2U + 24U);
}

TEST(Ahrs400, GarbageCostsOnlyItself) {
  // Random garbage can by chance look like the start of a packet and swallow a real one behind it;
  // the odds of 8-bit checksums allow that once in thousands of runs of garbage, not more.
  int lost = 0, invented = 0, runs = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    Unit unit(seed);
    Bytes bytes;
    std::vector<std::uint16_t> sent;
    for (int block = 0; block < 10; ++block) {
      for (int i = 0; i < 4; ++i) {
        Append(bytes, unit.Angle());
        sent.push_back(unit.counter());
      }
      Append(bytes, unit.Garbage(1 + (seed + static_cast<unsigned>(block) * 7) % 100));
      ++runs;
    }
    std::size_t found = 0;
    const auto counters = Decode(bytes).Counters();
    for (const std::uint16_t c : counters) {
      if (found < sent.size() && c == sent[found]) {
        ++found;
      } else {
        const auto ahead =
            std::find(sent.begin() + static_cast<std::ptrdiff_t>(found), sent.end(), c);
        if (ahead == sent.end()) {
          ++invented;
        } else {
          lost += static_cast<int>(ahead - sent.begin()) - static_cast<int>(found);
          found = static_cast<std::size_t>(ahead - sent.begin()) + 1;
        }
      }
    }
    lost += static_cast<int>(sent.size() - found);
  }
  EXPECT_LE(lost, 4) << "of 12000 packets around " << runs << " runs of garbage";
  EXPECT_LE(invented, 4);
}

TEST(Ahrs400, PacketsDirectlyAfterHeaderBytesAreKept) {
  Unit unit(5);
  for (std::size_t headers = 1; headers < 64; ++headers) {
    Bytes bytes(headers, 0xFF);
    for (int i = 0; i < 3; ++i) Append(bytes, unit.Angle());
    EXPECT_EQ(Decode(bytes).samples.size(), 3U) << headers;
  }
}

TEST(Ahrs400, HeaderBytesInThePayloadDoNotDistract) {
  // Everything -1: 26 of 28 payload bytes are header bytes.
  Bytes bytes;
  for (int i = 0; i < 50; ++i) {
    const auto counter = static_cast<std::uint16_t>(60000 - 1000 * i);
    Append(bytes, Packet({0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF,
                          0xFFFF, 0xFFFF, 0xFFFF, 0x05DC, counter}));
  }
  for (std::size_t cut = 0; cut < 30; ++cut) {
    const Bytes tail(bytes.begin() + static_cast<std::ptrdiff_t>(cut), bytes.end());
    const auto got = Decode(tail);
    EXPECT_EQ(got.samples.size(), cut == 0 ? 50U : 49U) << cut;
    EXPECT_EQ(got.samples.back().counter, 60000 - 49'000);
  }
}

TEST(Ahrs400, StartAnywhereFindsTheTruePacketsOnly) {
  std::size_t wrong = 0;
  for (std::uint32_t seed = 0; seed < 2000; ++seed) {
    Unit unit(seed);
    Bytes bytes;
    std::vector<std::uint16_t> sent;
    for (int i = 0; i < 6; ++i) {
      Append(bytes, unit.Angle());
      sent.push_back(unit.counter());
    }
    const std::size_t cut = seed % 30;
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(cut));
    if (cut > 0) sent.erase(sent.begin());
    if (Decode(bytes).Counters() != sent) ++wrong;
  }
  EXPECT_LE(wrong, 1U);
}

TEST(Ahrs400, DamagedPacketIsCountedAndCostsNoOther) {
  Unit unit(6);
  Bytes bytes;
  for (int i = 0; i < 10; ++i) {
    Bytes packet = unit.Angle();
    if (i == 4) packet[3] ^= 0x40;
    if (i == 6) packet[0] = 0;
    Append(bytes, packet);
  }
  Ahrs400Stats stats;
  EXPECT_EQ(Decode(bytes, 1U << 20, {}, &stats).samples.size(), 8U);
  EXPECT_EQ(stats.bad_checksum, 1U) << "the one without header is no packet with a bad checksum";
  EXPECT_EQ(stats.skipped_bytes, 60U);
}

TEST(Ahrs400, PacketBehindADamagedOneDoesNotWaitForItsSuccessor) {
  Unit unit(7);
  Ahrs400Decoder decoder;
  Collector sink;
  for (int i = 0; i < 3; ++i) decoder.Feed(kStart, unit.Angle(), sink);
  Bytes damaged = unit.Angle();
  damaged[5] ^= 1;
  decoder.Feed(kStart, damaged, sink);
  ASSERT_EQ(sink.samples.size(), 3U);
  decoder.Feed(kStart, unit.Angle(), sink);
  EXPECT_EQ(sink.samples.size(), 4U);
}

TEST(Ahrs400, FrozenUnitIsCountedAndNotMeasured) {
  Unit unit(8);
  Bytes bytes = unit.Angle();
  Append(bytes, unit.Angle());
  const Bytes stuck = unit.Angle();
  for (int i = 0; i < 5; ++i) Append(bytes, stuck);
  Append(bytes, unit.Angle());
  Ahrs400Stats stats;
  const Collector got = Decode(bytes, 1U << 20, {}, &stats);
  EXPECT_EQ(got.samples.size(), 4U);
  EXPECT_EQ(got.frozen, 4);
  EXPECT_EQ(stats.frozen, 4U);
  EXPECT_EQ(stats.packets[0], 8U);
}

TEST(Ahrs400, EqualDataWithAnotherCounterAreFresh) {
  Bytes bytes;
  for (std::uint16_t i = 0; i < 4; ++i) {
    Append(bytes, Packet({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 1500,
                          static_cast<std::uint16_t>(100 - i)}));
  }
  EXPECT_EQ(Decode(bytes).frozen, 0);
}

TEST(Ahrs400, LoneLastPacketComesOutAtTheEnd) {
  Unit unit(9);
  Bytes bytes{1, 2, 3, 4};
  Append(bytes, unit.Angle());
  Collector sink;
  Ahrs400Decoder decoder;
  decoder.Feed(kStart, bytes, sink);
  EXPECT_TRUE(sink.samples.empty());
  decoder.Finish(sink);
  EXPECT_EQ(sink.samples.size(), 1U);
  EXPECT_EQ(decoder.stats().skipped_bytes, 4U);
}

TEST(Ahrs400, RandomBytesAreNotMeasurements) {
  Unit unit(10);
  Ahrs400Stats stats;
  const Bytes garbage = unit.Garbage(4'000'000);
  Decode(garbage, 4096, {}, &stats);
  EXPECT_EQ(stats.Good(), 0U);
  EXPECT_EQ(stats.skipped_bytes, garbage.size());
}

TEST(Ahrs400, EveryByteIsAccountedFor) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const Bytes bytes = Mixture(seed);
    Ahrs400Stats s;
    Decode(bytes, 13, {}, &s);
    EXPECT_EQ(s.packets[0] * 30 + s.packets[1] * 24 + s.packets[2] * 24 + s.versions * 26 +
                  s.serial_numbers * 6 + s.skipped_bytes,
              bytes.size());
  }
}

TEST(Ahrs400, ResetForgetsHalfPackets) {
  Unit unit(11);
  Collector sink;
  Ahrs400Decoder decoder;
  const Bytes half = unit.Angle();
  decoder.Feed(kStart, std::span(half).first(20), sink);
  decoder.Reset();
  for (int i = 0; i < 3; ++i) decoder.Feed(kStart, unit.Angle(), sink);
  EXPECT_EQ(sink.samples.size(), 3U);
  EXPECT_EQ(decoder.stats().skipped_bytes, 20U);
}

TEST(Ahrs400, FeedDoesNotAllocate) {
  struct : Ahrs400Sink {
    std::uint64_t n = 0;
    void OnSample(const AhrsSample&, Ahrs400Mode) override { ++n; }
  } sink;
  const Bytes bytes = Mixture(12);
  Ahrs400Decoder decoder;
  const auto allocations = kawara::testing::CountAllocations([&] {
    for (int round = 0; round < 50; ++round) {
      for (std::size_t at = 0; at < bytes.size(); at += 17) {
        decoder.Feed(kStart + core::Milliseconds(round * 100),
                     std::span(bytes).subspan(at, std::min<std::size_t>(17, bytes.size() - at)),
                     sink);
      }
    }
  });
  EXPECT_EQ(allocations, 0U);
  EXPECT_GT(sink.n, 2000U);
  EXPECT_GT(kawara::testing::CountAllocations([] { delete new std::string(100, 'x'); }), 0U)
      << "the counter counts";
}

}  // namespace
}  // namespace kawara::drivers
