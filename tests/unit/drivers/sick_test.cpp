#include "drivers/sick.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/counting_allocator.hpp"

namespace kawara::drivers {
namespace {

using core::MonoTime;
using Bytes = std::vector<std::uint8_t>;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const MonoTime kStart = MonoTime::FromNs(5'000'000'000);

/// The telegrams of data/laser: "name": "02 00 ..".
std::map<std::string, Bytes> KnownTelegrams() {
  std::ifstream file(KAWARA_SOURCE_DIR "/data/laser/known_answer_telegrams.json");
  std::map<std::string, Bytes> telegrams;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> quoted;
    std::istringstream parts(line);
    for (std::string part; std::getline(parts, part, '"');) quoted.push_back(part);
    if (quoted.size() < 4) continue;
    std::istringstream hex(quoted[3]);
    for (std::string byte; hex >> byte;) {
      telegrams[quoted[1]].push_back(static_cast<std::uint8_t>(std::stoul(byte, nullptr, 16)));
    }
  }
  return telegrams;
}

Bytes ToBytes(const SickTelegram& t) { return {t.view().begin(), t.view().end()}; }
void Append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

/// A telegram from scanner 0, CRC by the bit rule written out once more: the register is shifted,
/// the polynomial 0x8005 goes in when a one falls out, then the last two bytes.
Bytes FromScanner(const Bytes& payload) {
  Bytes t{0x02, 0x80, static_cast<std::uint8_t>(payload.size() % 256),
          static_cast<std::uint8_t>(payload.size() / 256)};
  Append(t, payload);
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    crc = crc * 2;
    if (crc >= 0x10000) crc = (crc - 0x10000) ^ 0x8005;
    crc ^= t[i] + (i > 0 ? t[i - 1] * 256U : 0U);
  }
  t.push_back(static_cast<std::uint8_t>(crc % 256));
  t.push_back(static_cast<std::uint8_t>(crc / 256));
  return t;
}

Bytes ScanPayload(std::uint16_t count_word, const std::vector<std::uint16_t>& words,
                  std::uint8_t status = 0x10) {
  Bytes p{0xB0, static_cast<std::uint8_t>(count_word % 256),
          static_cast<std::uint8_t>(count_word / 256)};
  for (const std::uint16_t w : words)
    Append(p, {static_cast<std::uint8_t>(w % 256), static_cast<std::uint8_t>(w / 256)});
  p.push_back(status);
  return p;
}

/// 361 ranges of a PLS, one of them with flags, many with the bytes 0x02 and 0x06 inside.
Bytes PlsScan(std::uint16_t salt = 0) {
  std::vector<std::uint16_t> words(361);
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] = static_cast<std::uint16_t>(0x0200 + (i + salt) % 900);
  words[5] = 0xA123;
  return FromScanner(ScanPayload(361, words));
}

struct Collector : SickSink {
  std::vector<SickScan> scans;
  std::vector<std::pair<int, MonoTime>> messages;
  std::vector<Bytes> telegrams;
  std::string acks;
  void OnScan(const SickScan& s) override { scans.push_back(s); }
  void OnMessage(const SickMessage& m) override {
    messages.emplace_back(m.command, m.arrival);
    telegrams.emplace_back(m.telegram.begin(), m.telegram.end());
  }
  void OnAcknowledge(MonoTime, bool accepted) override { acks += accepted ? 'A' : 'N'; }
};

Collector Decode(const Bytes& bytes, std::size_t step = 1U << 20, const SickConfig& config = {},
                 SickStats* stats = nullptr) {
  Collector sink;
  SickDecoder decoder(config);
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    const std::size_t n = std::min(step, bytes.size() - at);
    decoder.Feed(kStart + static_cast<std::int64_t>(at) * config.ByteTime(),
                 std::span(bytes).subspan(at, n), sink);
  }
  decoder.Finish(sink);
  if (stats != nullptr) *stats = decoder.stats();
  return sink;
}

TEST(SickCommands, GiveTheKnownTelegrams) {
  auto known = KnownTelegrams();
  ASSERT_EQ(known.size(), 10U);
  const SickCommands c;
  EXPECT_EQ(ToBytes(c.RequestStatus()), known["status request"]);
  EXPECT_EQ(ToBytes(c.RequestType()), known["type request (0x3A)"]);
  EXPECT_EQ(ToBytes(c.Reset()), known["reset (0x10)"]);
  EXPECT_EQ(ToBytes(c.StreamAll()), known["stream all values (0x20 0x24)"]);
  EXPECT_EQ(ToBytes(c.OnRequest()), known["values on request / stop stream (0x20 0x25)"]);
  EXPECT_EQ(ToBytes(*c.SetBaud(38400)), known["baud 38400"]);
  EXPECT_EQ(ToBytes(*c.SetBaud(9600)), known["baud 9600"]);
  EXPECT_EQ(ToBytes(*c.SetBaud(500000)), known["baud 500000"]);
  EXPECT_EQ(ToBytes(*c.Installation("SICK_LMS")), known["installation mode SICK_LMS"]);
  EXPECT_EQ(ToBytes(*c.Installation("SICK_PLS")), known["installation mode SICK_PLS"]);
}

TEST(SickCommands, RefuseWhatTheScannerDoesNotKnow) {
  const auto baud = SickCommands().SetBaud(115200);
  ASSERT_FALSE(baud);
  EXPECT_THAT(baud.error().message, HasSubstr("expected 9600, 19200, 38400 or 500000"));
  EXPECT_FALSE(SickCommands().Installation("SHORT"));
  EXPECT_FALSE(SickCommands().Installation("MUCH_TOO_LONG"));
}

TEST(SickCommands, AddressAndRangeAreInTheirPlaces) {
  const Bytes t = ToBytes(SickCommands(3).StreamRange(0x0102, 0x0304));
  const Bytes expected_start{0x02, 0x03, 0x06, 0x00, 0x20, 0x27, 0x02, 0x01, 0x04, 0x03};
  ASSERT_EQ(t.size(), 12U);
  EXPECT_TRUE(std::equal(expected_start.begin(), expected_start.end(), t.begin()));
}

TEST(SickDecoder, ReadsTheKnownTelegramsBack) {
  SickConfig config;
  config.decode_requests = true;
  Bytes all;
  std::vector<Bytes> each;
  for (const auto& [name, bytes] : KnownTelegrams()) {
    Append(all, bytes);
    each.push_back(bytes);
  }
  SickStats stats;
  EXPECT_EQ(Decode(all, 3, config, &stats).telegrams, each);
  EXPECT_EQ(stats.skipped_bytes, 0U);
  EXPECT_TRUE(Decode(all).telegrams.empty()) << "live, only what the scanner says counts";
}

TEST(SickDecoder, PlsScanInMetresAndRadians) {
  const Bytes bytes = PlsScan();
  ASSERT_EQ(bytes.size(), 732U);
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 7),
              ElementsAre(0x02, 0x80, 0xD6, 0x02, 0xB0, 0x69, 0x01));
  const Collector got = Decode(bytes);
  ASSERT_EQ(got.scans.size(), 1U);
  const SickScan& s = got.scans[0];
  EXPECT_EQ(s.size, 361U);
  EXPECT_DOUBLE_EQ(s.RangeM(0), 5.12);
  EXPECT_DOUBLE_EQ(s.RangeM(360), 8.72);
  EXPECT_DOUBLE_EQ(s.RangeM(5), 0x0123 * 0.01);
  EXPECT_EQ(s.Flags(5), 5);
  EXPECT_EQ(s.Flags(6), 0);
  EXPECT_DOUBLE_EQ(s.AngleRad(0), 0.0);
  EXPECT_NEAR(s.AngleRad(180), 3.14159265358979 / 2, 1e-12);
  EXPECT_NEAR(s.AngleRad(360), 3.14159265358979, 1e-12);
  EXPECT_EQ(s.status, 0x10);
  EXPECT_EQ(s.arrival, kStart);
}

TEST(SickDecoder, SweepIsDatedBeforeItsTransmission) {
  SickConfig config;
  config.output_delay = core::Milliseconds(3);
  const SickScan s = Decode(PlsScan(), 1U << 20, config).scans.at(0);
  // Mirror 25 Hz: half a turn (20 ms) sweeps the 180 degrees.
  EXPECT_EQ(s.mid_sweep, kStart - core::Milliseconds(13));
  EXPECT_EQ(s.BeamTime(360), kStart - core::Milliseconds(3));
  EXPECT_EQ(s.BeamTime(0), kStart - core::Milliseconds(23));
  EXPECT_EQ(SickConfig::Pls101().ByteTime().count(), 11 * 1'000'000'000LL / 38400);
  EXPECT_EQ(SickConfig::Lms2xx().ByteTime().count(), 10 * 1'000'000'000LL / 38400);
}

TEST(SickDecoder, UnitsAndSweepsFollowTheCountWord) {
  const struct {
    std::size_t points;
    std::uint16_t high_bits;
    double metres_per_count, first_deg, step_deg;
  } kCases[] = {{361, 0x0000, 0.01, 0, 0.5},
                {361, 0x4000, 0.001, 0, 0.5},
                {181, 0x8000, 0.1, 0, 1},
                {101, 0x4000, 0.001, 40, 1},
                {201, 0x4000, 0.001, 40, 0.5},
                {401, 0x4000, 0.001, 40, 0.25},
                {181, 0x4000 | 0x2000 | 0x0800, 0.001, 0.25, 1},  // interlaced, second of four
                {17, 0x0000, 0.01, 0, 0}};
  for (const auto& c : kCases) {
    const auto word = static_cast<std::uint16_t>(c.points | c.high_bits);
    const auto got =
        Decode(FromScanner(ScanPayload(word, std::vector<std::uint16_t>(c.points, 1000))));
    ASSERT_EQ(got.scans.size(), 1U) << c.points;
    const SickScan& s = got.scans[0];
    EXPECT_EQ(s.size, c.points);
    EXPECT_DOUBLE_EQ(s.RangeM(0), 1000 * c.metres_per_count);
    EXPECT_NEAR(s.AngleRad(0) * 180 / 3.14159265358979, c.first_deg, 1e-9);
    EXPECT_NEAR((s.AngleRad(2) - s.AngleRad(1)) * 180 / 3.14159265358979, c.step_deg, 1e-9);
  }
}

TEST(SickDecoder, WiderRangesHaveFewerFlags) {
  SickConfig config;
  config.range_bits = 15;
  const SickScan s = Decode(PlsScan(), 1U << 20, config).scans.at(0);
  EXPECT_DOUBLE_EQ(s.RangeM(5), 0x2123 * 0.01);
  EXPECT_EQ(s.Flags(5), 1);
}

TEST(SickDecoder, PartOfAScanBeginsAtItsFirstValue) {
  Bytes p{0xB7, 0x5B, 0x00, 0x5D, 0x00, 0x03, 0x00, 0xE8, 0x03, 0xE9, 0x03, 0xEA, 0x03, 0x10};
  const auto got = Decode(FromScanner(p));
  ASSERT_EQ(got.scans.size(), 1U);
  EXPECT_EQ(got.scans[0].size, 3U);
  EXPECT_NEAR(got.scans[0].AngleRad(0) * 180 / 3.14159265358979, 45.0, 1e-9);
  EXPECT_DOUBLE_EQ(got.scans[0].RangeM(2), 10.02);
}

TEST(SickDecoder, TelegramAndTurnNumbersBehindTheValuesAreAllowed) {
  for (int extra = 1; extra <= 2; ++extra) {
    Bytes p = ScanPayload(181, std::vector<std::uint16_t>(181, 77));
    p.insert(p.end() - 1, static_cast<std::size_t>(extra), std::uint8_t{42});
    const auto got = Decode(FromScanner(p));
    ASSERT_EQ(got.scans.size(), 1U);
    EXPECT_EQ(got.scans[0].size, 181U);
    EXPECT_EQ(got.scans[0].status, 0x10);
  }
}

TEST(SickDecoder, UnknownUnitIsATelegramButNoScan) {
  SickStats stats;
  const auto got = Decode(FromScanner(ScanPayload(0xC000 | 3, {1, 2, 3})), 1U << 20, {}, &stats);
  EXPECT_EQ(got.messages.size(), 1U);
  EXPECT_TRUE(got.scans.empty());
  EXPECT_EQ(stats.bad_scans, 1U);
}

TEST(SickDecoder, AcknowledgementsCountOnlyInTheirPlace) {
  Bytes bytes{0x06};
  Append(bytes, FromScanner({0xA0, 0x00, 0x10}));
  Append(bytes, {0x15, 0x15, 0x06});
  Append(bytes, FromScanner({0x92, 0x10}));
  Append(bytes, {0x77, 0x06, 0x15});  // behind garbage they are garbage
  Append(bytes, FromScanner({0xB1, 0x10}));
  SickStats stats;
  const auto got = Decode(bytes, 1U << 20, {}, &stats);
  EXPECT_EQ(got.acks, "ANNA");
  EXPECT_EQ(stats.acks, 2U);
  EXPECT_EQ(stats.naks, 2U);
  EXPECT_EQ(stats.skipped_bytes, 3U);
  EXPECT_EQ(got.messages.size(), 3U);
}

Bytes Mixture(std::uint32_t seed) {
  std::mt19937 random(seed);
  Bytes bytes = PlsScan();
  bytes.erase(bytes.begin(), bytes.begin() + 300);
  for (std::uint16_t i = 0; i < 4; ++i) {
    Append(bytes, {0x06});
    Append(bytes, PlsScan(i));
    Append(bytes, FromScanner({0xA0, 0x00, 0x10}));
    for (std::size_t n = random() % 200; n > 0; --n)
      bytes.push_back(static_cast<std::uint8_t>(random()));
  }
  Bytes damaged = PlsScan(9);
  damaged[200] ^= 0x20;
  Append(bytes, damaged);
  Append(bytes, PlsScan(10));
  return bytes;
}

TEST(SickDecoder, AnySplitGivesTheSameResult) {
  const Bytes bytes = Mixture(1);
  SickStats whole_stats;
  const Collector whole = Decode(bytes, 1U << 20, {}, &whole_stats);
  ASSERT_EQ(whole.scans.size(), 5U);
  for (const std::size_t step : {1U, 2U, 3U, 5U, 7U, 64U, 255U, 256U, 731U, 732U, 733U, 4096U}) {
    SickStats stats;
    const Collector split = Decode(bytes, step, {}, &stats);
    EXPECT_EQ(split.messages, whole.messages) << step;
    EXPECT_EQ(split.telegrams, whole.telegrams) << step;
    EXPECT_EQ(split.acks, whole.acks) << step;
    EXPECT_EQ(stats.skipped_bytes, whole_stats.skipped_bytes) << step;
    EXPECT_EQ(stats.bad_checksum, whole_stats.bad_checksum) << step;
  }
}

TEST(SickDecoder, DamagedTelegramIsCountedAndCostsNoOther) {
  Bytes bytes = PlsScan(1);
  Bytes damaged = PlsScan(2);
  damaged[100] ^= 1;
  Append(bytes, damaged);
  Append(bytes, PlsScan(3));
  SickStats stats;
  EXPECT_EQ(Decode(bytes, 1U << 20, {}, &stats).scans.size(), 2U);
  EXPECT_EQ(stats.bad_checksum, 1U);
  EXPECT_EQ(stats.skipped_bytes, 732U);
}

TEST(SickDecoder, EverySingleBitErrorIsFound) {
  const Bytes good = FromScanner({0xB1, 0x12, 0x34, 0x56, 0x10});
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_TRUE(Decode(bad).messages.empty()) << bit;
  }
}

TEST(SickDecoder, GarbageCostsOnlyItself) {
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    Bytes bytes;
    for (std::uint16_t i = 0; i < 5; ++i) {
      for (std::size_t n = random() % 100; n > 0; --n)
        bytes.push_back(static_cast<std::uint8_t>(random()));
      if (random() % 2 == 0) bytes.push_back(0x02);
      Append(bytes, PlsScan(i));
    }
    SickStats stats;
    EXPECT_EQ(Decode(bytes, 97, {}, &stats).scans.size(), 5U) << seed;
    EXPECT_EQ(stats.skipped_bytes + 5 * 732 + stats.acks + stats.naks, bytes.size());
  }
}

TEST(SickDecoder, FalseStartDoesNotSwallowTheTelegramsBehindIt) {
  Bytes bytes{0x02, 0x80, 0x00, 0x08, 0xA0};  // a telegram of 2048 bytes that never comes
  for (std::uint16_t i = 0; i < 2; ++i) Append(bytes, PlsScan(i));
  EXPECT_EQ(Decode(bytes).scans.size(), 2U);
}

TEST(SickDecoder, RandomBytesAreNoTelegrams) {
  std::mt19937 random(3);
  Bytes garbage(2'000'000);
  for (auto& b : garbage) b = static_cast<std::uint8_t>(random());
  SickStats stats;
  Decode(garbage, 4096, {}, &stats);
  EXPECT_EQ(stats.telegrams, 0U);
  EXPECT_EQ(stats.skipped_bytes + stats.acks + stats.naks, garbage.size());
}

TEST(SickDecoder, FeedDoesNotAllocate) {
  struct : SickSink {
    int n = 0;
    void OnScan(const SickScan&) override { ++n; }
  } sink;
  const Bytes bytes = Mixture(5);
  SickDecoder decoder;
  EXPECT_EQ(kawara::testing::CountAllocations([&] {
              for (int i = 0; i < 50; ++i) decoder.Feed(kStart, bytes, sink);
            }),
            0U);
  EXPECT_EQ(sink.n, 250);
}

}  // namespace
}  // namespace kawara::drivers
