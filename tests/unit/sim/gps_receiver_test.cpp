#include "sim/instruments/gps_receiver.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "drivers/crc24q.hpp"
#include "drivers/gnss_epoch.hpp"
#include "drivers/gnss_stream.hpp"
#include "sim/motion/motion_track.hpp"

namespace kawara::sim {
namespace {

using drivers::AshtechCbn;
using drivers::AshtechTimeTag;
using drivers::NmeaGga;

const core::MonoTime kMono = core::MonoTime::FromNs(500'000'000'000);

const Recording& Drive() {
  static const Recording drive =
      LoadRecording(std::filesystem::path(KAWARA_SOURCE_DIR) / "data/drive_0708").value();
  return drive;
}

/// A receiver 60 s into the drive and a host that decodes it with the project's own drivers.
class Bench : public drivers::GnssStreamSink, public drivers::GnssFixSink {
 public:
  explicit Bench(const GpsReceiverOptions& options, int seconds = 60)
      : begin(Drive().begin() + core::Seconds(60)),
        clock(begin, kMono, 1.0),
        receiver(Drive(), clock, begin, begin + core::Seconds(seconds), options),
        assembler_({.profile = options.gga_quality == GgaQuality::kNmea23
                                   ? drivers::ReceiverProfile::kNmea
                                   : drivers::ReceiverProfile::kAshtechLegacy,
                    .reference = core::ToUtc(begin),
                    .not_before = {},
                    .timeout = core::Milliseconds(400)}) {}

  /// Lets time pass in steps of a millisecond and decodes what comes.
  void Pass(double seconds) {
    const core::MonoTime end = now + core::DurationFromSeconds(seconds);
    for (; now < end; now += core::Milliseconds(1)) {
      receiver.Advance(now);
      const UartTransmitter::Chunk chunk = receiver.transmitter().TakeSent(now);
      if (chunk.bytes.empty()) continue;
      text.append(chunk.bytes.begin(), chunk.bytes.end());
      decoder_.Feed(now, chunk.bytes, *this);
    }
  }
  std::string Ask(const std::string& command) {
    text.clear();
    const std::string line = command + "\r\n";
    receiver.Receive(now, {reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
    Pass(0.2);
    return text;
  }

  core::GpsTime begin;
  SimClock clock;
  GpsReceiver receiver;
  core::MonoTime now = kMono;
  std::string text;  ///< everything sent since the last Ask
  std::vector<core::GnssFix> fixes;
  std::vector<NmeaGga> gga;
  std::vector<AshtechCbn> cbn;
  std::vector<AshtechTimeTag> tags;
  std::vector<core::MonoTime> tag_arrivals;
  const drivers::GnssStreamDecoder::Stats& stats() const { return decoder_.stats(); }

 private:
  void OnMessage(const drivers::GnssMessage& message) override {
    if (const auto* m = message.Nmea<NmeaGga>()) gga.push_back(*m);
    if (const auto* m = message.Ashtech<AshtechCbn>()) cbn.push_back(*m);
    if (const auto* m = message.Ashtech<AshtechTimeTag>()) {
      tags.push_back(*m);
      tag_arrivals.push_back(message.arrival);
    }
    assembler_.OnMessage(message, *this);
  }
  void OnFix(const core::GnssFix& fix) override { fixes.push_back(fix); }

  drivers::GnssStreamDecoder decoder_;
  drivers::GnssEpochAssembler assembler_;
};

GpsReceiverOptions Streaming() {
  GpsReceiverOptions options;
  options.streaming = true;
  options.baud_bps = 115200;
  return options;
}

TEST(GpsReceiver, FixesDecodedFromItsBytesAreTheRecordedOnes) {
  Bench bench(Streaming());
  bench.Pass(40.0);
  ASSERT_GT(bench.fixes.size(), 150U);
  EXPECT_EQ(bench.stats().bad_checksum, 0U);
  EXPECT_EQ(bench.stats().invalid, 0U);
  EXPECT_EQ(bench.stats().skipped_bytes, 0U);
  const MotionTrack track(Drive());
  for (const core::GnssFix& fix : bench.fixes) {
    const RecordedFix& truth = track.NearestFix(fix.time);
    ASSERT_EQ(fix.time, truth.time);  // to the nanosecond, 18 leap seconds and a date apart
    ASSERT_EQ(fix.rtk, truth.rtk);
    // Minutes with seven decimals: 0.1 mm to either side.
    ASSERT_NEAR(fix.antenna.lat_rad, truth.antenna.lat_rad, 0.6e-7 / 60.0 * core::kRadFromDeg);
    ASSERT_NEAR(fix.antenna.lon_rad, truth.antenna.lon_rad, 0.6e-7 / 60.0 * core::kRadFromDeg);
    ASSERT_NEAR(fix.antenna.h_ellipsoidal_m, truth.antenna.h_ellipsoidal_m, 1e-4);
    ASSERT_TRUE(fix.covariance_from_receiver);
    ASSERT_NEAR(std::sqrt(fix.position_cov_enu_m2(0, 0)), truth.sd_ned_m.y(), 6e-5);
    ASSERT_NEAR(std::sqrt(fix.position_cov_enu_m2(2, 2)), truth.sd_ned_m.z(), 6e-5);
    ASSERT_NEAR(fix.velocity_enu_mps.x(), truth.velocity_ned_mps.y(), 6e-4);
    ASSERT_NEAR(fix.velocity_enu_mps.y(), truth.velocity_ned_mps.x(), 6e-4);
    ASSERT_NEAR(fix.velocity_enu_mps.z(), -truth.velocity_ned_mps.z(), 6e-4);
    // Arrival: latency as stated, plus at most the test's own step.
    const double late_s = core::ToSeconds(fix.arrival - bench.clock.MonoAt(fix.time));
    EXPECT_NEAR(fix.latency_s, late_s, 0.002) << (&fix - bench.fixes.data());
    EXPECT_GT(late_s, 0.0349);
    EXPECT_LT(late_s, 0.1);
  }
}

TEST(GpsReceiver, BothGgaEncodingsTellTheRecordedState) {
  for (const GgaQuality encoding : {GgaQuality::kAshtechLegacy, GgaQuality::kNmea23}) {
    GpsReceiverOptions options = Streaming();
    options.gga_quality = encoding;
    Bench bench(options);
    bench.Pass(2.0);
    ASSERT_FALSE(bench.gga.empty());
    EXPECT_EQ(bench.gga.front().quality, encoding == GgaQuality::kAshtechLegacy ? 3 : 4);
  }
}

TEST(GpsReceiver, SilentUntilToldToSpeak) {
  Bench bench({});
  bench.Pass(3.0);
  EXPECT_EQ(bench.text, "");
  EXPECT_EQ(bench.Ask("$PASHQ,RID").rfind("$PASHR,RID,UZ", 0), 0U);
  EXPECT_EQ(bench.Ask("$PASHS,NME,GGA,B,ON"), "$PASHR,ACK*3D\r\n");
  bench.Pass(3.0);
  EXPECT_TRUE(bench.gga.empty()) << "the other port speaks where nobody hears";
  bench.Ask("$PASHS,NME,GGA,A,ON");
  bench.Pass(3.0);
  EXPECT_GE(bench.gga.size(), 3U);
}

TEST(GpsReceiver, PeriodIsKeptOnFullSeconds) {
  Bench bench({});
  bench.Ask("$PASHS,NME,GGA,A,ON");
  bench.Ask("$PASHS,NME,PER,5");
  bench.gga.clear();
  bench.Pass(31.0);
  ASSERT_GE(bench.gga.size(), 6U);
  for (const NmeaGga& gga : bench.gga) {
    const std::int64_t ms =
        gga.time_utc->count() / 1'000'000 + 18'000 + 1;  // GPS scale; epochs are 1 ms early
    EXPECT_EQ(ms % 5000, 0);
  }
}

TEST(GpsReceiver, WithoutCpdTheSolutionIsAutonomousAndSaysSo) {
  Bench bench({});
  bench.Ask("$PASHS,SPD,A,9");
  bench.Ask("$PASHS,OUT,A,CBN");
  bench.Ask("$PASHS,RCI,0.1");
  bench.Pass(20.0);
  ASSERT_GT(bench.fixes.size(), 50U);
  const MotionTrack track(Drive());
  double worst_m = 0.0;
  for (const core::GnssFix& fix : bench.fixes) {
    ASSERT_EQ(fix.rtk, core::RtkState::kAutonomous);
    const core::Geodetic truth = track.NearestFix(fix.time).antenna;
    worst_m = std::max(
        worst_m, (core::EcefFromGeodetic(fix.antenna) - core::EcefFromGeodetic(truth)).norm());
    EXPECT_GT(std::sqrt(fix.position_cov_enu_m2(0, 0)), 1.0);
  }
  EXPECT_GT(worst_m, 0.3);
  EXPECT_LT(worst_m, 20.0);
}

TEST(GpsReceiver, RoverSetUpInTheRightOrderGivesTheFix) {
  Bench bench({});
  for (const char* command : {"$PASHS,SPD,A,9", "$PASHS,RTC,REM,B", "$PASHS,CPD,MOD,ROV",
                              "$PASHS,OUT,A,CBN", "$PASHS,RCI,0.1"}) {
    bench.Ask(command);
  }
  bench.Pass(3.0);
  ASSERT_FALSE(bench.fixes.empty());
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kFixed);
  bench.Ask("$PASHS,RTC,REM,A");  // after MOD: kills CPD
  bench.Pass(1.0);
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kAutonomous);
}

TEST(GpsReceiver, RepliesLeaveAtTheOldRateThenTheNewOneHolds) {
  Bench bench({});
  const std::string command = "$PASHS,SPD,A,9\r\n";
  bench.receiver.Receive(bench.now,
                         {reinterpret_cast<const std::uint8_t*>(command.data()), command.size()});
  const UartTransmitter::Chunk ack =
      bench.receiver.transmitter().TakeSent(bench.now + core::Seconds(1));
  EXPECT_EQ(ack.baud_bps, 9600);
  EXPECT_EQ(std::string(ack.bytes.begin(), ack.bytes.end()), "$PASHR,ACK*3D\r\n");
  EXPECT_EQ(bench.receiver.transmitter().baud_bps(), 115200);
}

TEST(GpsReceiver, CommandsInPiecesAndBetweenGarbageAreUnderstood) {
  Bench bench({});
  const std::string noise = std::string("\xD3\x00\x13$PASHS,NME,GG\x01", 16) + "$PAS";
  const std::string rest = "HQ,PRT\n";
  for (const std::string& piece : {noise, rest}) {
    bench.receiver.Receive(bench.now,
                           {reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()});
  }
  bench.Pass(0.2);
  EXPECT_EQ(bench.text, WithChecksum("PASHR,PRT,A,5"));
}

TEST(GpsReceiver, PpsTagsNameEachGpsSecondWithin100Ms) {
  Bench bench(Streaming());
  bench.Pass(10.0);
  ASSERT_GE(bench.tags.size(), 9U);
  for (std::size_t i = 0; i < bench.tags.size(); ++i) {
    EXPECT_FALSE(bench.tags[i].is_event);
    EXPECT_EQ(bench.tags[i].time_of_week.count() % 1'000'000'000, 0);
    const core::GpsTime pulse = core::ResolveTimeOfWeek(bench.tags[i].time_of_week, bench.begin);
    const double late_s = core::ToSeconds(bench.tag_arrivals[i] - bench.clock.MonoAt(pulse));
    EXPECT_GT(late_s, 0.01);
    EXPECT_LT(late_s, 0.1);
  }
}

TEST(GpsReceiver, TriggersAreTimeTaggedButOnlyTheFirstBetweenTwoEpochs) {
  Bench bench(Streaming());
  bench.Ask("$PASHS,NME,PTT,A,OFF");
  bench.Pass(2.0);
  bench.tags.clear();
  const core::MonoTime pulse = bench.now + core::Nanoseconds(123'456'789);
  bench.Pass(0.124);
  bench.receiver.AddEvent(pulse);
  bench.receiver.AddEvent(pulse + core::Nanoseconds(1'000'000));
  bench.Pass(0.5);
  ASSERT_EQ(bench.tags.size(), 1U);
  EXPECT_TRUE(bench.tags[0].is_event);
  const core::GpsTime tagged = core::ResolveTimeOfWeek(bench.tags[0].time_of_week, bench.begin);
  EXPECT_LE(std::abs((tagged - bench.clock.GpsAt(pulse)).count()), 50);  // printed to 100 ns
  EXPECT_EQ(bench.receiver.counters().events_suppressed, 1U);
}

TEST(GpsReceiver, NoFixMeansEmptyFieldsAndNoCbn) {
  Bench bench(Streaming());
  bench.receiver.SetFaults({.no_fix = true});
  bench.Pass(2.0);
  ASSERT_GE(bench.gga.size(), 7U);
  EXPECT_TRUE(bench.cbn.empty());
  for (const NmeaGga& gga : bench.gga) {
    EXPECT_EQ(gga.quality, 0);
    EXPECT_FALSE(gga.has_position);
  }
  EXPECT_EQ(bench.stats().invalid, 0U);
  EXPECT_NE(bench.text.find("$PASHR,LTN,"), std::string::npos);
}

TEST(GpsReceiver, BadChecksumsAreAllBad) {
  Bench bench(Streaming());
  bench.receiver.SetFaults({.bad_checksum = true});
  bench.Pass(1.0);
  EXPECT_EQ(bench.stats().good, 0U);
  EXPECT_GT(bench.stats().bad_checksum, 20U);
}

TEST(GpsReceiver, PowerOffForgetsWhatWasNotSaved) {
  Bench bench({});
  bench.Ask("$PASHS,NME,GGA,A,ON");
  bench.Ask("$PASHS,SAV,Y");
  bench.Ask("$PASHS,NME,ZDA,A,ON");
  bench.receiver.SetFaults({.power_off = true});
  bench.text.clear();
  bench.Pass(2.0);
  EXPECT_EQ(bench.text, "");
  bench.receiver.SetFaults({});
  bench.Pass(3.0);
  EXPECT_NE(bench.text.find("$GPGGA"), std::string::npos);
  EXPECT_EQ(bench.text.find("$GPZDA"), std::string::npos);
}

TEST(GpsReceiver, WithoutCorrectionsTheFixDecaysToFloatThenAutonomous) {
  GpsReceiverOptions options = Streaming();
  options.needs_corrections = true;
  Bench bench(options, 200);
  bench.Ask("$PASHS,RTC,MAX,20");
  bench.Pass(1.0);
  ASSERT_FALSE(bench.fixes.empty());
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kAutonomous);
  // The RTCM standard's message 1005 is no observation; a 1004 header with right CRC is enough
  // here.
  const auto feed = [&] {
    std::vector<std::uint8_t> frame{0xD3, 0x00, 0x02, 1004 >> 4, (1004 & 15) << 4};
    const std::uint32_t crc = drivers::Crc24q(frame);
    for (const int shift : {16, 8, 0}) frame.push_back(static_cast<std::uint8_t>(crc >> shift));
    bench.receiver.Receive(bench.now, frame);
  };
  feed();
  bench.Pass(2.0);
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kFixed);
  EXPECT_NEAR(bench.fixes.back().correction_age_s, 2.0, 1.01);
  bench.Pass(11.0);
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kFloat);
  bench.Pass(10.0);
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kAutonomous);
}

TEST(GpsReceiver, AfterLostCorrectionsItTakesItsTimeToFixAgain) {
  GpsReceiverOptions options = Streaming();
  options.needs_corrections = true;
  options.refix_s = 5.0;
  Bench bench(options, 200);
  const auto feed = [&](double seconds) {
    std::vector<std::uint8_t> frame{0xD3, 0x00, 0x02, 1004 >> 4, (1004 & 15) << 4};
    const std::uint32_t crc = drivers::Crc24q(frame);
    for (const int shift : {16, 8, 0}) frame.push_back(static_cast<std::uint8_t>(crc >> shift));
    for (double passed = 0.0; passed < seconds; passed += 1.0) {
      bench.receiver.Receive(bench.now, frame);
      bench.Pass(1.0);
    }
  };
  bench.Pass(1.0);
  feed(4.0);
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kFloat);
  feed(3.0);
  EXPECT_EQ(bench.fixes.back().rtk, core::RtkState::kFixed);
}

TEST(GpsReceiver, NeverBetterThanTheSkyOfItsRecording) {
  Recording lost = Drive();
  for (RecordedFix& fix : lost.fixes) fix.rtk = core::RtkState::kNone;
  const core::GpsTime begin = lost.begin() + core::Seconds(60);
  const SimClock clock(begin, kMono, 1.0);
  for (const bool needs_corrections : {false, true}) {
    GpsReceiverOptions options = Streaming();
    options.needs_corrections = needs_corrections;
    GpsReceiver receiver(lost, clock, begin, begin + core::Seconds(10), options);
    std::string text;
    for (int ms = 0; ms < 3000; ++ms) {
      receiver.Advance(kMono + core::Milliseconds(ms));
      const auto chunk = receiver.transmitter().TakeSent(kMono + core::Milliseconds(ms));
      text.append(chunk.bytes.begin(), chunk.bytes.end());
    }
    EXPECT_NE(text.find("$GPGGA"), std::string::npos);
    EXPECT_EQ(text.find("$PASHR,CBN"), std::string::npos);
  }
}

TEST(GpsReceiver, ClockStepMovesEveryTimeTagByASecondAndNothingElse) {
  Bench good(Streaming());
  Bench stepped(Streaming());
  stepped.receiver.SetFaults({.clock_step = true});
  good.Pass(5.0);
  stepped.Pass(5.0);
  ASSERT_EQ(good.fixes.size(), stepped.fixes.size());
  ASSERT_GT(good.fixes.size(), 10U);
  EXPECT_EQ(stepped.fixes[9].time - good.fixes[9].time, core::Seconds(1));
  EXPECT_EQ(stepped.fixes[9].arrival, good.fixes[9].arrival);
  EXPECT_EQ(stepped.fixes[9].antenna.lat_rad, good.fixes[9].antenna.lat_rad);
  ASSERT_EQ(good.tags.size(), stepped.tags.size());
  EXPECT_EQ(stepped.tags[1].time_of_week - good.tags[1].time_of_week, core::Seconds(1));
}

TEST(GpsReceiver, LostPulsesAreNotReportedFixesGoOn) {
  Bench bench(Streaming());
  bench.receiver.SetFaults({.no_pps = true});
  bench.Pass(5.0);
  EXPECT_TRUE(bench.tags.empty());
  EXPECT_GT(bench.fixes.size(), 10U);
}

TEST(GpsReceiver, SameSeedSameBytes) {
  Bench a(Streaming());
  Bench b(Streaming());
  a.Pass(5.0);
  b.Pass(5.0);
  EXPECT_EQ(a.text, b.text);
}

}  // namespace
}  // namespace kawara::sim
