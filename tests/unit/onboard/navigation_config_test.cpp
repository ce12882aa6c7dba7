// What a robot's YAML says of its inertial unit, down to the filter.
#include <gtest/gtest.h>

#include "core/config/config.hpp"
#include "onboard/navigation_chain.hpp"

namespace kawara::onboard {
namespace {

core::Expected<NavigationSettings> Read(const std::string& yaml) {
  return core::config::Parse<NavigationSettings>(yaml, "robot.yaml");
}

TEST(NavigationConfig, FiguresReplaceThoseOfTheSensorsProfile) {
  const auto settings = Read(
      "sensor: industrial-mems\nimu:\n  angle_walk_deg_per_sqrt_h: 0.6\n  gyro_scale: 0.004\n");
  ASSERT_TRUE(settings) << settings.error().message;
  OnboardConfig config;
  config.navigation = *settings;
  const estimation::ImuNoise noise = FilterConfig(config).imu;
  const estimation::ImuNoise profile = *estimation::FindSensorProfile("industrial-mems");
  EXPECT_NEAR(noise.gyro_arw_rad_rts, 1.745329e-4, 1e-9);
  EXPECT_EQ(noise.gyro_scale, 0.004);
  EXPECT_EQ(noise.accel_bias_mps2, profile.accel_bias_mps2);
}

TEST(NavigationConfig, FiguresAreInTheLogsConfiguration) {
  const auto settings = Read("imu: {accel_bias_mg: 4, gyro_instability_degph: 6}\n");
  ASSERT_TRUE(settings) << settings.error().message;
  const auto again = Read(core::config::Dump(*settings));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->imu.accel_bias_mg, 4.0);
  EXPECT_EQ(again->imu.gyro_instability_degph, 6.0);
  EXPECT_FALSE(again->imu.gyro_scale);
}

TEST(NavigationConfig, MistakesInFiguresNameTheirPlace) {
  const auto settings = Read("sensor: consumer-mems\nimu:\n  gyro_scale: 3\n");
  ASSERT_FALSE(settings);
  EXPECT_NE(settings.error().message.find("robot.yaml:3:15: imu.gyro_scale = 3: expected"),
            std::string::npos)
      << settings.error().message;
}

}  // namespace
}  // namespace kawara::onboard
