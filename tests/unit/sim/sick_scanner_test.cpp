#include "sim/instruments/sick_scanner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "drivers/sick.hpp"

namespace kawara::sim {
namespace {

const core::MonoTime kMono = core::MonoTime::FromNs(700'000'000'000);
const core::GpsTime kGps = core::GpsTime::FromNs(1'400'000'000'000'000'000);

/// A room of 6 by 4 m seen from its middle, and how far beam i goes in it.
float Room(std::size_t i) {
  const double angle = static_cast<double>(i) * 0.5 * core::kRadFromDeg;
  const double to_side = 3.0 / std::max(std::abs(std::cos(angle)), 1e-9);
  const double to_front = 2.0 / std::max(std::abs(std::sin(angle)), 1e-9);
  return static_cast<float>(std::min(to_side, to_front));
}

/// A scanner and a host that decodes it with the project's own driver.
class Bench : public drivers::SickSink {
 public:
  explicit Bench(const SickScannerOptions& options = {})
      : scanner_(
            [this](core::GpsTime ahead, std::span<float> ranges) {
              casts.push_back(ahead);
              for (std::size_t i = 0; i < ranges.size(); ++i) ranges[i] = Room(i);
              ranges[100] = 60.0F;
              ranges[101] = INFINITY;
              ranges[102] = NAN;
            },
            clock_, kGps, kGps + core::Seconds(600), options) {}

  void Pass(double seconds) {
    const core::MonoTime end = now + core::DurationFromSeconds(seconds);
    for (; now < end; now += core::Nanoseconds(100'000)) {
      scanner_.Advance(now);
      for (;;) {
        const UartTransmitter::Chunk chunk = scanner_.transmitter().TakeSent(now);
        if (chunk.bytes.empty()) break;
        bytes += chunk.bytes.size();
        last_baud_bps = chunk.baud_bps;
        for (const std::uint8_t byte : chunk.bytes)
          decoder_.Feed(now - core::Nanoseconds(11 * 1'000'000'000LL / chunk.baud_bps), {&byte, 1},
                        *this);
      }
    }
  }
  /// Commands of its replies since.
  std::vector<int> Ask(std::span<const std::uint8_t> telegram, double seconds = 0.4) {
    replies.clear();
    acks.clear();
    scanner_.Receive(now, telegram);
    Pass(seconds);
    return replies;
  }
  std::vector<int> Ask(const drivers::SickTelegram& telegram, double seconds = 0.4) {
    return Ask(telegram.view(), seconds);
  }

  SickScanner& scanner() { return scanner_; }
  const drivers::SickStats& stats() const { return decoder_.stats(); }
  const SimClock& clock() const { return clock_; }
  core::MonoTime now = kMono;
  std::vector<core::GpsTime> casts;
  std::vector<drivers::SickScan> scans;
  std::vector<int> replies;
  std::vector<std::uint8_t> last_data;
  std::string acks;
  int mode_reply = -1;
  std::size_t bytes = 0;
  int last_baud_bps = 0;

 private:
  void OnScan(const drivers::SickScan& scan) override { scans.push_back(scan); }
  void OnMessage(const drivers::SickMessage& message) override {
    replies.push_back(message.command);
    last_data.assign(message.data.begin(), message.data.end());
    if (message.command == 0xA0) mode_reply = message.data[0];
  }
  void OnAcknowledge(core::MonoTime /*arrival*/, bool accepted) override {
    acks += accepted ? 'A' : 'N';
  }
  static drivers::SickConfig HostConfig() {
    drivers::SickConfig config = drivers::SickConfig::Pls101();
    config.output_delay = core::Milliseconds(2);
    return config;
  }
  SimClock clock_{kGps, kMono, 1.0};
  SickScanner scanner_;
  drivers::SickDecoder decoder_{HostConfig()};
};

SickScannerOptions Exact() {
  SickScannerOptions options;
  options.baud_bps = 38400;
  options.range_noise_m = 0.0;
  return options;
}

TEST(SickScanner, SilentUntilAsked) {
  Bench bench;
  bench.Pass(2.0);
  EXPECT_EQ(bench.bytes, 0U);
  EXPECT_TRUE(bench.casts.empty()) << "casts rays only for scans that are sent";
}

TEST(SickScanner, StreamedScansAreTheRoom) {
  Bench bench(Exact());
  bench.Ask(drivers::SickCommands().StreamAll());
  EXPECT_EQ(bench.replies.front(), 0xA0);
  EXPECT_EQ(bench.acks, "A");
  bench.Pass(5.0);
  ASSERT_GT(bench.scans.size(), 20U);
  EXPECT_EQ(bench.stats().skipped_bytes, 0U);
  EXPECT_EQ(bench.stats().bad_checksum, 0U);
  for (const drivers::SickScan& scan : bench.scans) {
    ASSERT_EQ(scan.size, 361U);
    for (std::size_t i = 0; i < 361; ++i) {
      if (i >= 100 && i <= 102) {
        ASSERT_DOUBLE_EQ(scan.RangeM(i), 81.91) << "nothing within 50 m";
      } else {
        ASSERT_NEAR(scan.RangeM(i), static_cast<double>(Room(i)), 0.0051);
      }
    }
  }
}

TEST(SickScanner, LineSetsTheScanRateAndEvenParityCounts) {
  const struct {
    int baud_bps;
    double scans_per_s;
  } cases[] = {{9600, 1.19}, {38400, 4.76}, {500000, 25.0}};
  for (const auto& c : cases) {
    SickScannerOptions options = Exact();
    options.baud_bps = c.baud_bps;
    Bench bench(options);
    bench.Ask(drivers::SickCommands().StreamAll());
    bench.Pass(20.0);
    // 732 bytes of 11 bits, then the next whole turn of the mirror.
    EXPECT_NEAR(static_cast<double>(bench.scans.size()) / 20.2, c.scans_per_s, 0.13 * c.scans_per_s)
        << c.baud_bps;
    EXPECT_EQ(bench.scanner().transmitter().dropped_messages(), 0U);
  }
}

TEST(SickScanner, HostDatesTheSweepWithinAMillisecond) {
  SickScannerOptions options = Exact();
  options.mirror_skew_ppm = 0.0;
  Bench bench(options);
  bench.Ask(drivers::SickCommands().StreamAll());
  bench.Pass(5.0);
  ASSERT_EQ(bench.casts.size() - bench.scans.size(), 1U) << "the last is still on the line";
  for (std::size_t i = 0; i < bench.scans.size(); ++i) {
    const core::MonoTime truth = bench.clock().MonoAt(bench.casts[i]);
    EXPECT_NEAR(core::ToSeconds(bench.scans[i].mid_sweep - truth), 0.0, 0.001);
  }
}

TEST(SickScanner, MirrorRunsOnItsOwnMotor) {
  SickScannerOptions options = Exact();
  options.baud_bps = 500000;
  options.mirror_skew_ppm = 2000.0;
  Bench bench(options);
  bench.Ask(drivers::SickCommands().StreamAll());
  bench.Pass(10.0);
  const double turn_s = core::ToSeconds(bench.casts.back() - bench.casts.front()) /
                        static_cast<double>(bench.casts.size() - 1);
  EXPECT_NEAR(turn_s / 0.04, 1.0 / 1.002, 1e-6);
}

TEST(SickScanner, ObeysTheDialogueOfItsDrivers) {
  Bench bench;
  const drivers::SickCommands say;
  EXPECT_EQ(bench.Ask(say.RequestStatus()), std::vector<int>{0xB1});
  EXPECT_EQ(bench.Ask(say.RequestType()), std::vector<int>{0xBA});
  EXPECT_EQ(std::string(bench.last_data.begin(), bench.last_data.begin() + 6), "PLS101");
  EXPECT_EQ(bench.Ask(*say.Installation("SICK_LMS")), std::vector<int>{0xA0});
  EXPECT_EQ(bench.last_data[0], 1) << "wrong password";
  EXPECT_EQ(bench.Ask(*say.Installation("SICK_PLS")), std::vector<int>{0xA0});
  EXPECT_EQ(bench.last_data[0], 0);
  EXPECT_EQ(bench.Ask(*say.SetBaud(38400)), std::vector<int>{0xA0});
  EXPECT_EQ(bench.last_baud_bps, 9600) << "answered at the old rate";
  EXPECT_EQ(bench.Ask(say.OnRequest()), std::vector<int>{0xA0});
  EXPECT_EQ(bench.last_baud_bps, 38400);
  EXPECT_EQ(bench.Ask(say.RequestScan()), std::vector<int>{0xB0}) << "one, and no more";
  EXPECT_GE(bench.Ask(say.StreamAll(), 2.0).size(), 8U);
  const std::vector<int> stopping = bench.Ask(say.OnRequest(), 1.0);
  EXPECT_EQ(stopping.back(), 0xA0);
  EXPECT_LE(stopping.size(), 2U);
  EXPECT_EQ(bench.Ask(*say.SetBaud(500000)), std::vector<int>{0xA0});
  EXPECT_EQ(bench.last_data[0], 1) << "not wired by RS-422";
}

TEST(SickScanner, PartOfAScan) {
  Bench bench(Exact());
  bench.Ask(drivers::SickCommands().StreamRange(91, 271), 2.0);
  ASSERT_GT(bench.scans.size(), 5U);
  EXPECT_EQ(bench.scans[0].size, 181U);
  EXPECT_NEAR(bench.scans[0].AngleRad(0) * core::kDegFromRad, 45.0, 1e-9);
  EXPECT_NEAR(bench.scans[0].RangeM(0), static_cast<double>(Room(90)), 0.0051);
  EXPECT_NEAR(bench.scans[0].RangeM(180), static_cast<double>(Room(270)), 0.0051);
  bench.mode_reply = -1;
  const std::vector<int> after = bench.Ask(drivers::SickCommands().StreamRange(300, 200), 1.0);
  EXPECT_EQ(bench.mode_reply, 1) << "impossible";
  EXPECT_EQ(after.back(), 0xB7) << "goes on as before";
}

TEST(SickScanner, RefusesWhatItDoesNotKnowOrCannotRead) {
  Bench bench;
  const std::uint8_t unknown[] = {0x55};
  EXPECT_EQ(bench.Ask(drivers::MakeSickTelegram(0, unknown)), std::vector<int>{0x92});
  EXPECT_EQ(bench.acks, "N");
  drivers::SickTelegram damaged = drivers::SickCommands().RequestStatus();
  damaged.bytes[4] ^= 1;
  EXPECT_TRUE(bench.Ask(damaged).empty());
  EXPECT_EQ(bench.acks, "N");
  EXPECT_TRUE(bench.Ask(drivers::SickCommands(5).RequestStatus()).empty()) << "for another";
  EXPECT_EQ(bench.acks, "");
  EXPECT_EQ(bench.scanner().counters().refused, 2U);
}

TEST(SickScanner, TelegramsArriveInAnyPieces) {
  Bench bench;
  const drivers::SickTelegram t = drivers::SickCommands().RequestStatus();
  for (const std::uint8_t byte : t.view()) {
    bench.scanner().Receive(bench.now, {&byte, 1});
    bench.Pass(0.002);
  }
  bench.Pass(0.3);
  EXPECT_EQ(bench.replies, std::vector<int>{0xB1});
  // Half a telegram, a pause, and a whole one: the half is forgotten.
  bench.scanner().Receive(bench.now, t.view().first(5));
  bench.Pass(0.2);
  EXPECT_EQ(bench.Ask(t), std::vector<int>{0xB1});
}

TEST(SickScanner, ResetAndPowerCutForgetEverything) {
  SickScannerOptions options;
  options.boot_s = 1.0;
  Bench bench(options);
  bench.Ask(*drivers::SickCommands().SetBaud(38400));
  bench.Ask(drivers::SickCommands().StreamAll(), 1.0);
  EXPECT_EQ(bench.last_baud_bps, 38400);
  const std::vector<int> reset = bench.Ask(drivers::SickCommands().Reset(), 2.0);
  EXPECT_EQ(reset.back(), 0x90) << "greets, then is silent";
  EXPECT_EQ(bench.last_data.size() + 7, 29U);
  EXPECT_EQ(bench.last_baud_bps, 9600);

  bench.Ask(drivers::SickCommands().StreamAll(), 2.0);
  bench.scanner().SetPower(bench.now, false);
  const std::size_t before = bench.bytes;
  bench.Pass(2.0);
  EXPECT_EQ(bench.bytes, before);
  bench.scanner().SetPower(bench.now, true);
  bench.Pass(3.0);
  EXPECT_EQ(bench.bytes - before, 29U) << "greets, and streams no more";
}

TEST(SickScanner, NoiseHasItsSizeAndItsSeed) {
  SickScannerOptions options = Exact();
  options.baud_bps = 500000;
  options.range_noise_m = 0.04;
  Bench bench(options);
  bench.Ask(drivers::SickCommands().StreamAll());
  bench.Pass(5.0);
  double square = 0.0;
  int n = 0;
  for (const drivers::SickScan& scan : bench.scans) {
    for (std::size_t i = 110; i < 361; ++i, ++n)
      square += std::pow(scan.RangeM(i) - static_cast<double>(Room(i)), 2);
  }
  EXPECT_NEAR(std::sqrt(square / n), std::hypot(0.04, 0.01 / std::sqrt(12.0)), 0.001);
  Bench again(options);
  again.Ask(drivers::SickCommands().StreamAll());
  again.Pass(5.0);
  ASSERT_EQ(again.scans.size(), bench.scans.size());
  EXPECT_EQ(again.scans.back().words, bench.scans.back().words);
}

}  // namespace
}  // namespace kawara::sim
