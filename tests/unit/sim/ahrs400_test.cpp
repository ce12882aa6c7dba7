#include "sim/instruments/ahrs400.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "drivers/ahrs400.hpp"
#include "sim/motion/motion_track.hpp"

namespace kawara::sim {
namespace {

const core::MonoTime kMono = core::MonoTime::FromNs(500'000'000'000);

struct Trace {
  Recording drive =
      LoadRecording(std::filesystem::path(KAWARA_SOURCE_DIR) / "data/drive_0708").value();
  MotionTrack track{drive};
  std::vector<AhrsState> states = MakeAhrsTrace(drive, track, 7);
};
const Trace& TheTrace() {
  static const Trace trace;
  return trace;
}

class Bench : public drivers::Ahrs400Sink {
 public:
  explicit Bench(const Ahrs400Options& options,
                 drivers::Ahrs400Mode mode = drivers::Ahrs400Mode::kAngle)
      : begin(TheTrace().drive.begin() + core::Seconds(100)),
        clock(begin, kMono, 1.0),
        unit(TheTrace().states, clock, begin, begin + core::Seconds(100), options),
        decoder_(MakeConfig(mode)) {}

  void Pass(double seconds) {
    const core::MonoTime end = now + core::DurationFromSeconds(seconds);
    for (; now < end; now += core::Nanoseconds(100'000)) {
      unit.Advance(now);
      const UartTransmitter::Chunk chunk = unit.transmitter().TakeSent(now);
      if (chunk.bytes.empty()) continue;
      bytes.insert(bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
      decoder_.Feed(now, chunk.bytes, *this);
    }
  }
  std::vector<std::uint8_t> Ask(char command) {
    bytes.clear();
    const auto byte = static_cast<std::uint8_t>(command);
    unit.Receive(now, {&byte, 1});
    Pass(0.05);
    return bytes;
  }

  core::GpsTime begin;
  SimClock clock;
  Ahrs400 unit;
  core::MonoTime now = kMono;
  std::vector<std::uint8_t> bytes;
  std::vector<core::AhrsSample> samples;
  const drivers::Ahrs400Stats& stats() const { return decoder_.stats(); }

 private:
  static drivers::Ahrs400Config MakeConfig(drivers::Ahrs400Mode mode) {
    drivers::Ahrs400Config config;
    config.mode = mode;
    return config;
  }
  void OnSample(const core::AhrsSample& sample, drivers::Ahrs400Mode /*mode*/) override {
    samples.push_back(sample);
  }
  drivers::Ahrs400Decoder decoder_;
};

Ahrs400Options Quiet() {
  Ahrs400Options options;
  options.already_streaming = false;
  return options;
}

/// The recorded sample whose packet this is.
const AhrsState& Origin(const Bench& bench, const core::AhrsSample& sample) {
  const core::GpsTime t = bench.clock.GpsAt(sample.arrival - core::Milliseconds(2));
  const auto& states = TheTrace().states;
  const auto after =
      std::lower_bound(states.begin(), states.end(), t,
                       [](const AhrsState& s, core::GpsTime value) { return s.time < value; });
  const auto before = after - 1;
  return after->time - t < t - before->time ? *after : *before;
}

TEST(Ahrs400Sim, DecodedSamplesAreTheRecordedOnesWithinQuantisation) {
  Bench bench({});
  bench.Pass(30.0);
  // Duplicates in the recording carry new counters, so that none is taken for a frozen unit.
  EXPECT_EQ(bench.stats().bad_checksum, 0U);
  EXPECT_EQ(bench.stats().skipped_bytes, 0U);
  ASSERT_GT(bench.samples.size(), 2950U);
  for (const core::AhrsSample& sample : bench.samples) {
    const AhrsState& origin = Origin(bench, sample);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_NEAR(sample.rate_radps[axis], origin.rate_radps[axis],
                  0.51 * 150.0 / 32768 * core::kRadFromDeg);
      ASSERT_NEAR(sample.specific_force_mps2[axis], origin.specific_force_mps2[axis],
                  0.51 * 3.0 * 9.81 / 32768 + 1e-4);
      ASSERT_NEAR(sample.magnetic_gauss[axis], origin.magnetic_gauss[axis], 0.51 * 1.875 / 32768);
    }
    ASSERT_TRUE(sample.has_attitude);
    const double half_step_rad = 0.51 * 180.0 / 32768 * core::kRadFromDeg;
    ASSERT_NEAR(core::WrapPi(sample.attitude.roll_rad - origin.attitude.roll_rad), 0.0,
                half_step_rad);
    ASSERT_NEAR(core::WrapPi(sample.attitude.pitch_rad - origin.attitude.pitch_rad), 0.0,
                half_step_rad);
    ASSERT_NEAR(core::WrapPi(sample.attitude.yaw_rad - origin.attitude.yaw_rad), 0.0,
                half_step_rad);
    ASSERT_NEAR(sample.temperature_degc, 31.0, 0.03);
  }
}

TEST(Ahrs400Sim, CounterRunsDownOnItsOwnCrystal) {
  Ahrs400Options options;
  options.counter_skew_ppm = 200.0;
  Bench bench(options);
  bench.Pass(60.0);
  std::int64_t ticks = 0;
  for (std::size_t i = 1; i < bench.samples.size(); ++i) {
    const auto step =
        static_cast<std::uint16_t>(bench.samples[i - 1].counter - bench.samples[i].counter);
    ASSERT_GT(step, 9000);   // 8 ms apart at least
    ASSERT_LT(step, 16000);  // 12 ms at most: no packet left out
    ticks += step;
  }
  const double seconds = core::ToSeconds(Origin(bench, bench.samples.back()).time -
                                         Origin(bench, bench.samples.front()).time);
  EXPECT_NEAR(static_cast<double>(ticks) * 0.79e-6 / seconds, 1.0 + 200e-6, 1e-6);
}

TEST(Ahrs400Sim, ClockStepIsAJumpOfTheCounterThereAndBack) {
  Bench bench({});
  bench.Pass(0.5);
  bench.unit.SetClockStep(true);
  bench.Pass(0.5);
  bench.unit.SetClockStep(false);
  bench.Pass(0.5);
  int ahead = 0;
  int back = 0;
  for (std::size_t i = 1; i < bench.samples.size(); ++i) {
    const auto step =
        static_cast<std::uint16_t>(bench.samples[i - 1].counter - bench.samples[i].counter);
    if (step > 28000 && step < 36000) ++ahead;  // 10 ms and 16 ms
    if (step > 57000 || step < 1000) ++back;    // 10 ms less 16 ms, modulo 2^16
  }
  EXPECT_EQ(ahead, 1);
  EXPECT_EQ(back, 1);
}

TEST(Ahrs400Sim, ObeysPingModesPollAndContinuous) {
  Bench bench(Quiet());
  bench.Pass(0.5);
  EXPECT_TRUE(bench.bytes.empty());
  EXPECT_EQ(bench.Ask('R'), std::vector<std::uint8_t>{'H'});
  EXPECT_EQ(bench.Ask('c'), std::vector<std::uint8_t>{'C'});
  EXPECT_EQ(bench.Ask('G').size(), 24U);
  EXPECT_EQ(bench.Ask('r'), std::vector<std::uint8_t>{'R'});
  EXPECT_EQ(bench.Ask('G').size(), 24U);
  EXPECT_EQ(bench.Ask('a'), std::vector<std::uint8_t>{'A'});
  EXPECT_EQ(bench.Ask('G').size(), 30U);
  EXPECT_EQ(bench.Ask('b'), std::vector<std::uint8_t>{'B'});
  EXPECT_TRUE(bench.Ask('x').empty());
  EXPECT_GE(bench.Ask('C').size(), 4U * 30U);
  bench.Ask('P');
  EXPECT_TRUE(bench.Ask('P').empty());
  const auto version = bench.Ask('v');
  ASSERT_EQ(version.size(), 26U);
  EXPECT_EQ(std::string(version.begin() + 1, version.begin() + 14), "AHRS400CC-100");
  const auto serial = bench.Ask('S');
  ASSERT_EQ(serial.size(), 6U);
  EXPECT_EQ(serial[0], 0xFF);
}

TEST(Ahrs400Sim, PingStopsAStreamLeftFromTheLastRun) {
  Bench bench({});
  bench.Pass(0.5);
  EXPECT_FALSE(bench.bytes.empty());
  bench.Ask('R');
  EXPECT_TRUE(bench.Ask('P').empty());
}

TEST(Ahrs400Sim, ScaledModeDecodesToo) {
  Bench bench(Quiet(), drivers::Ahrs400Mode::kScaled);
  bench.Ask('c');
  bench.Ask('C');
  bench.Pass(1.0);
  EXPECT_GT(bench.samples.size(), 90U);
  EXPECT_FALSE(bench.samples.back().has_attitude);
}

TEST(Ahrs400Sim, ValuesBeyondTheRangeAreLimitedAndCounted) {
  Ahrs400Encoder encoder({});
  AhrsState state;
  state.rate_radps = {3.0, -3.0, 0.0};  // 172 deg/s against a full scale of 150
  const auto packet = encoder.Packet(Ahrs400Output::kAngle, state, 20.0, 0);
  EXPECT_EQ(encoder.saturated(), 2U);
  EXPECT_EQ((packet[7] << 8) | packet[8], 0x7FFF);
  EXPECT_EQ((packet[9] << 8) | packet[10], 0x8000);
}

TEST(Ahrs400Sim, SlowLineLeavesSamplesOutInsteadOfFallingBehind) {
  Ahrs400Options options;
  options.baud_bps = 9600;  // 32 packets a second at most
  Bench bench(options);
  bench.Pass(10.0);
  EXPECT_GT(bench.unit.counters().skipped, 600U);
  EXPECT_EQ(bench.unit.counters().packets + bench.unit.counters().skipped,
            bench.unit.counters().samples);
  EXPECT_EQ(bench.unit.transmitter().dropped_messages(), 0U);
}

TEST(AhrsTrace, ARecordingsOwnMagneticFieldIsUsedAsItIs) {
  Recording drive = TheTrace().drive;
  drive.imu.resize(50);
  for (RecordedImu& sample : drive.imu) sample.magnetic_gauss = Eigen::Vector3d(0.1, -0.2, 0.4);
  for (const AhrsState& state : MakeAhrsTrace(drive, TheTrace().track, 7))
    ASSERT_EQ(state.magnetic_gauss, Eigen::Vector3d(0.1, -0.2, 0.4));
}

TEST(CoarseAttitudeFilter, HeadingFollowsTheTrackThroughTheDeclination) {
  const Trace& trace = TheTrace();
  const double declination = trace.drive.site.declination_rad;
  std::vector<double> errors_deg;
  for (std::size_t i = 3000; i < trace.states.size(); i += 50) {
    const AhrsState& s = trace.states[i];
    const double true_yaw = trace.track.YawAt(s.time - core::Milliseconds(90));
    errors_deg.push_back(std::abs(core::WrapPi(s.attitude.yaw_rad + declination - true_yaw)) *
                         core::kDegFromRad);
  }
  std::sort(errors_deg.begin(), errors_deg.end());
  EXPECT_LT(errors_deg[errors_deg.size() / 2], 1.0);
  EXPECT_LT(errors_deg.back(), 6.0);
}

TEST(CoarseAttitudeFilter, LevelAndNorthAtRest) {
  CoarseAttitudeFilter filter;
  AhrsState state;
  state.specific_force_mps2 = {0.0, 0.0, -9.80665};
  state.magnetic_gauss = {0.2, 0.0, 0.45};
  for (int i = 0; i < 1000; ++i) filter.Update(0.01, state);
  EXPECT_NEAR(filter.attitude().roll_rad, 0.0, 1e-9);
  EXPECT_NEAR(filter.attitude().pitch_rad, 0.0, 1e-9);
  EXPECT_NEAR(filter.attitude().yaw_rad, 0.0, 1e-9);
}

TEST(CoarseAttitudeFilter, RollRightIsPositiveAndNoseUpIsPositive) {
  CoarseAttitudeFilter filter;
  AhrsState state;
  const core::Attitude tilted{0.2, 0.1, 1.0};
  const Eigen::Matrix3d R_body_ned = core::RotationNedFromBody(tilted).transpose();
  state.specific_force_mps2 = R_body_ned * Eigen::Vector3d(0, 0, -9.80665);
  state.magnetic_gauss = R_body_ned * Eigen::Vector3d(0.2, 0.0, 0.45);
  filter.Update(0.01, state);
  EXPECT_NEAR(filter.attitude().roll_rad, 0.2, 1e-9);
  EXPECT_NEAR(filter.attitude().pitch_rad, 0.1, 1e-9);
  EXPECT_NEAR(filter.attitude().yaw_rad, 1.0, 1e-9);
}

}  // namespace
}  // namespace kawara::sim
