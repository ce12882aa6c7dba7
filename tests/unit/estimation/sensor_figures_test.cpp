#include "estimation/sensor_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::estimation {
namespace {

const ImuNoise kProfile = *FindSensorProfile("ahrs400cc-100");

struct Case {
  const char* name;
  std::optional<double> SensorFigures::*figure;
  double value;
  double ImuNoise::*field;
  double expected;  ///< worked out by hand
};

class OneFigure : public ::testing::TestWithParam<Case> {};
TEST_P(OneFigure, ReplacesThatOfTheProfileAndNoOther) {
  const Case& c = GetParam();
  SensorFigures figures;
  figures.*c.figure = c.value;
  ImuNoise noise = WithFigures(kProfile, figures);
  EXPECT_NEAR(noise.*c.field, c.expected, 1e-6 * c.expected);
  noise.*c.field = kProfile.*c.field;
  for (const auto field :
       {&ImuNoise::gyro_arw_rad_rts, &ImuNoise::accel_vrw_mps_rts, &ImuNoise::gyro_bias_radps,
        &ImuNoise::accel_bias_mps2, &ImuNoise::gyro_bias_rw, &ImuNoise::accel_bias_rw,
        &ImuNoise::gyro_scale, &ImuNoise::accel_scale, &ImuNoise::gyro_misalignment,
        &ImuNoise::accel_misalignment, &ImuNoise::gyro_range_radps, &ImuNoise::accel_range_mps2}) {
    EXPECT_EQ(noise.*field, kProfile.*field);
  }
}
INSTANTIATE_TEST_SUITE_P(
    All, OneFigure,
    ::testing::Values(
        Case{"angle_walk", &SensorFigures::angle_walk_deg_per_sqrt_h, 0.6,
             &ImuNoise::gyro_arw_rad_rts, 1.745329e-4},
        Case{"velocity_walk", &SensorFigures::velocity_walk_mps_per_sqrt_h, 0.12,
             &ImuNoise::accel_vrw_mps_rts, 2.0e-3},
        Case{"gyro_bias", &SensorFigures::gyro_bias_degps, 1.0, &ImuNoise::gyro_bias_radps,
             1.7453293e-2},
        Case{"accel_bias", &SensorFigures::accel_bias_mg, 10.0, &ImuNoise::accel_bias_mps2,
             9.80665e-2},
        // 10 deg/h = 4.848137e-5 rad/s, times sqrt(2 / 300 s) = 0.0816497
        Case{"gyro_instability", &SensorFigures::gyro_instability_degph, 10.0,
             &ImuNoise::gyro_bias_rw, 3.958487e-6},
        Case{"accel_instability", &SensorFigures::accel_instability_mg, 0.1,
             &ImuNoise::accel_bias_rw, 8.007100e-5},
        Case{"gyro_walk", &SensorFigures::gyro_walk_degph_per_sqrt_h, 60.0, &ImuNoise::gyro_bias_rw,
             4.848137e-6},
        Case{"accel_walk", &SensorFigures::accel_walk_mg_per_sqrt_h, 0.6, &ImuNoise::accel_bias_rw,
             9.80665e-5},
        Case{"gyro_scale", &SensorFigures::gyro_scale, 0.003, &ImuNoise::gyro_scale, 0.003},
        Case{"accel_scale", &SensorFigures::accel_scale, 0.003, &ImuNoise::accel_scale, 0.003},
        Case{"gyro_misalignment", &SensorFigures::gyro_misalignment, 0.003,
             &ImuNoise::gyro_misalignment, 0.003},
        Case{"accel_misalignment", &SensorFigures::accel_misalignment, 0.003,
             &ImuNoise::accel_misalignment, 0.003},
        Case{"gyro_range", &SensorFigures::gyro_range_degps, 500.0, &ImuNoise::gyro_range_radps,
             8.7266463},
        Case{"accel_range", &SensorFigures::accel_range_g, 3.0, &ImuNoise::accel_range_mps2,
             29.41995}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(SensorFigures, InstabilityAndWalkOfABiasAddUp) {
  SensorFigures both, instability, walk;
  both.gyro_instability_degph = instability.gyro_instability_degph = 20.0;
  both.instability_tau_s = instability.instability_tau_s = 100.0;
  both.gyro_walk_degph_per_sqrt_h = walk.gyro_walk_degph_per_sqrt_h = 80.0;
  EXPECT_DOUBLE_EQ(WithFigures(kProfile, both).gyro_bias_rw,
                   std::hypot(WithFigures(kProfile, instability).gyro_bias_rw,
                              WithFigures(kProfile, walk).gyro_bias_rw));
}

}  // namespace
}  // namespace kawara::estimation
