#include "drivers/ahrs400_packet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/drivers/ahrs400_collector.hpp"

namespace kawara::drivers {
namespace {

using core::AhrsSample;
using testing::Append;
using testing::Bytes;
using testing::Collector;
using testing::Decode;
using ::testing::ElementsAre;
using testing::kStart;
using testing::Packet;

/// roll 45, pitch -22.5, heading -90 (deg); rates 10, -20, 30 % and accelerations 50, -25, -12.5 %
/// of full scale; mag 1/2, -1/4, 1/8; temperature 2.5 V; counter 0x1234.
Bytes KnownAngle() {
  return Packet({0x2000, 0xF000, 0xC000, 0x0CCD, 0xE667, 0x2666, 0x4000, 0xE000, 0xF000, 0x4000,
                 0xE000, 0x1000, 0x0800, 0x1234});
}

TEST(Ahrs400Packet, AnglePacketOfA100Unit) {
  const Collector got = Decode(KnownAngle());
  ASSERT_EQ(got.samples.size(), 1U);
  const AhrsSample& s = got.samples[0];
  constexpr double kPi = 3.14159265358979323846;
  EXPECT_TRUE(s.has_attitude);
  EXPECT_NEAR(s.attitude.roll_rad, kPi / 4, 1e-12);
  EXPECT_NEAR(s.attitude.pitch_rad, -kPi / 8, 1e-12);
  EXPECT_NEAR(s.attitude.yaw_rad, -kPi / 2, 1e-12);
  // 0x0CCD = 3277, 0xE667 = -6553, 0x2666 = 9830; full scale 32768 = 150 deg/s.
  EXPECT_NEAR(s.rate_radps.x(), 3277.0 * 150 / 32768 * kPi / 180, 1e-12);
  EXPECT_NEAR(s.rate_radps.y(), -6553.0 * 150 / 32768 * kPi / 180, 1e-12);
  EXPECT_NEAR(s.rate_radps.z(), 9830.0 * 150 / 32768 * kPi / 180, 1e-12);
  // Full scale 3 g.
  EXPECT_NEAR(s.specific_force_mps2.x(), 1.5 * 9.80665, 1e-12);
  EXPECT_NEAR(s.specific_force_mps2.y(), -0.75 * 9.80665, 1e-12);
  EXPECT_NEAR(s.specific_force_mps2.z(), -0.375 * 9.80665, 1e-12);
  // Full scale 1.875 gauss.
  EXPECT_NEAR(s.magnetic_gauss.x(), 0.9375, 1e-12);
  EXPECT_NEAR(s.magnetic_gauss.y(), -0.46875, 1e-12);
  EXPECT_NEAR(s.magnetic_gauss.z(), 0.234375, 1e-12);
  // 0x0800 = 2048 counts of 4096 = 2.5 V.
  EXPECT_NEAR(s.temperature_degc, 44.44 * (2.5 - 1.375), 1e-9);
  EXPECT_EQ(s.counter, 0x1234);
  EXPECT_EQ(s.arrival, kStart);
}

TEST(Ahrs400Packet, A200UnitHasTwiceTheRange) {
  Ahrs400Config config;
  config.scaling = Ahrs400Scaling::Model200();
  const AhrsSample a = Decode(KnownAngle()).samples.at(0);
  const AhrsSample b = Decode(KnownAngle(), 1U << 20, config).samples.at(0);
  EXPECT_TRUE(b.rate_radps.isApprox(2.0 * a.rate_radps));
  EXPECT_TRUE(b.specific_force_mps2.isApprox(2.0 * a.specific_force_mps2));
  EXPECT_EQ(b.magnetic_gauss, a.magnetic_gauss);
  EXPECT_EQ(b.attitude.roll_rad, a.attitude.roll_rad);
}

TEST(Ahrs400Packet, AccelerationSignIsConfigurationAndTouchesNothingElse) {
  Ahrs400Config config;
  config.scaling = Ahrs400Scaling::Model100(-1.0);
  const AhrsSample a = Decode(KnownAngle()).samples.at(0);
  const AhrsSample b = Decode(KnownAngle(), 1U << 20, config).samples.at(0);
  EXPECT_EQ(b.specific_force_mps2, -a.specific_force_mps2);
  EXPECT_EQ(b.rate_radps, a.rate_radps);
}

TEST(Ahrs400Packet, TemperatureIsUnsigned) {
  Bytes two;
  for (const std::uint16_t counter : {std::uint16_t{3}, std::uint16_t{2}}) {
    Append(two, Packet({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x9000, counter}));
  }
  EXPECT_NEAR(Decode(two).samples.at(0).temperature_degc, 44.44 * (36864.0 * 5 / 4096 - 1.375),
              1e-9);
}

TEST(Ahrs400Packet, ScaledPacketHasTheSameWordsWithoutAngles) {
  const Bytes bytes = Packet(
      {0x0CCD, 0xE667, 0x2666, 0x4000, 0xE000, 0xF000, 0x4000, 0xE000, 0x1000, 0x0800, 0x1234});
  for (const Ahrs400Mode expected : {Ahrs400Mode::kAngle, Ahrs400Mode::kScaled}) {
    Ahrs400Config config;
    config.mode = expected;
    const Collector got = Decode(bytes, 1U << 20, config);
    ASSERT_EQ(got.samples.size(), 1U);
    EXPECT_THAT(got.modes, ElementsAre(Ahrs400Mode::kScaled));
    const AhrsSample reference = Decode(KnownAngle()).samples.at(0);
    EXPECT_FALSE(got.samples[0].has_attitude);
    EXPECT_EQ(got.samples[0].rate_radps, reference.rate_radps);
    EXPECT_EQ(got.samples[0].specific_force_mps2, reference.specific_force_mps2);
    EXPECT_EQ(got.samples[0].magnetic_gauss, reference.magnetic_gauss);
    EXPECT_EQ(got.samples[0].temperature_degc, reference.temperature_degc);
    EXPECT_EQ(got.samples[0].counter, 0x1234);
  }
}

TEST(Ahrs400Packet, VoltagePacketInVolts) {
  Ahrs400Config config;
  config.mode = Ahrs400Mode::kVoltage;
  const Bytes bytes = Packet({0, 0x800, 0xFFF, 1, 2, 3, 4, 5, 6, 0x800, 0x1234});
  const Collector got = Decode(bytes, 1U << 20, config);
  ASSERT_EQ(got.voltages.size(), 1U);
  EXPECT_THAT(got.voltages[0].gyro_v, ElementsAre(0.0, 2.5, 4095.0 * 5 / 4096));
  EXPECT_DOUBLE_EQ(got.voltages[0].magnetometer_v[2], 6.0 * 5 / 4096);
  EXPECT_NEAR(got.voltages[0].temperature_degc, 49.995, 1e-9);
  EXPECT_TRUE(got.samples.empty());
}

TEST(Ahrs400Packet, ModelSuffixIsReadFromTheVersion) {
  EXPECT_EQ(Ahrs400ModelSuffix("AHRS400CC-100 v1.08"), 100);
  EXPECT_EQ(Ahrs400ModelSuffix("AHRS400CD-200"), 200);
  EXPECT_EQ(Ahrs400ModelSuffix("AHRS400CA-1000"), 0);
  EXPECT_EQ(Ahrs400ModelSuffix("AHRS400CA"), 0);
  EXPECT_EQ(Ahrs400ModelSuffix(""), 0);
}

}  // namespace
}  // namespace kawara::drivers
