#include "estimation/sensor_profile.hpp"

#include <gtest/gtest.h>

#include <string>

namespace kawara::estimation {
namespace {

TEST(SensorProfile, EveryNameFindsItsProfile) {
  ASSERT_EQ(SensorProfiles().size(), 3U);
  for (const SensorProfile& profile : SensorProfiles()) {
    const auto found = FindSensorProfile(profile.name);
    ASSERT_TRUE(found) << profile.name;
    EXPECT_EQ(found->gyro_arw_rad_rts, profile.noise.gyro_arw_rad_rts);
    EXPECT_FALSE(profile.about.empty());
  }
}

TEST(SensorProfile, NamesOfTheConfigurationAreThere) {
  for (const char* name : {"ahrs400cc-100", "consumer-mems", "industrial-mems"}) {
    EXPECT_TRUE(FindSensorProfile(name)) << name;
  }
}

TEST(SensorProfile, UnknownNameFindsNothing) {
  EXPECT_FALSE(FindSensorProfile("ahrs400cc"));
  EXPECT_FALSE(FindSensorProfile(""));
}

/// The data sheet's 2.25 deg per root hour and 0.1 m/s per root hour, by hand.
TEST(SensorProfile, UnitsAreSi) {
  const auto unit = FindSensorProfile("ahrs400cc-100");
  ASSERT_TRUE(unit);
  EXPECT_NEAR(unit->gyro_arw_rad_rts, 6.545e-4, 1e-6);
  EXPECT_NEAR(unit->accel_vrw_mps_rts, 1.667e-3, 1e-6);
  EXPECT_NEAR(unit->accel_bias_mps2, 0.08336, 1e-4);
}

/// A better class of unit is better in everything a filter believes.
TEST(SensorProfile, IndustrialIsBetterThanConsumer) {
  const auto industrial = FindSensorProfile("industrial-mems");
  const auto consumer = FindSensorProfile("consumer-mems");
  ASSERT_TRUE(industrial && consumer);
  EXPECT_LT(industrial->gyro_arw_rad_rts, consumer->gyro_arw_rad_rts);
  EXPECT_LT(industrial->accel_vrw_mps_rts, consumer->accel_vrw_mps_rts);
  EXPECT_LT(industrial->gyro_bias_radps, consumer->gyro_bias_radps);
  EXPECT_LT(industrial->accel_bias_mps2, consumer->accel_bias_mps2);
  EXPECT_LT(industrial->gyro_bias_rw, consumer->gyro_bias_rw);
}

}  // namespace
}  // namespace kawara::estimation
