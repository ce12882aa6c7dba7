#include "sim/render/sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::sim {
namespace {

double LinearFromSrgb(double s) {
  s /= 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
};
Statistics Measure(const SensorSettings& settings, float signal) {
  const Sensor sensor(settings);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kPixels = 40000;
  for (std::uint32_t i = 0; i < kPixels; ++i) {
    std::array<std::uint8_t, 3> rgb;
    sensor.Expose({signal, signal, signal}, 7, i, rgb.data());
    for (const std::uint8_t c : rgb) {
      const double x = LinearFromSrgb(c);
      sum += x;
      squares += x * x;
    }
  }
  const double n = 3.0 * kPixels;
  return {sum / n, std::sqrt(squares / n - sum / n * sum / n)};
}

TEST(Sensor, NoiseIsThatOfElectronsAndOfReading) {
  SensorSettings settings;
  settings.full_well_e = 2000.0;
  settings.read_noise_e = 30.0;
  for (const float signal : {0.10F, 0.25F, 0.50F, 0.70F}) {
    const Statistics s = Measure(settings, signal);
    const double electrons = 2000.0 * static_cast<double>(signal);
    EXPECT_NEAR(s.mean, static_cast<double>(signal), 0.002) << signal;
    EXPECT_NEAR(s.deviation, std::sqrt(electrons + 900.0) / 2000.0, 0.001) << signal;
  }
}

TEST(Sensor, WithoutNoiseTheCurveIsSrgb) {
  SensorSettings settings;
  settings.full_well_e = 0.0;
  const Sensor sensor(settings);
  for (const auto& [linear, byte] : std::vector<std::pair<float, int>>{{0.0F, 0},
                                                                       {0.0031308F, 10},
                                                                       {0.2140F, 127},
                                                                       {0.5F, 188},
                                                                       {1.0F, 255},
                                                                       {3.0F, 255},
                                                                       {-1.0F, 0}}) {
    std::array<std::uint8_t, 3> rgb;
    sensor.Expose({linear, linear, linear}, 1, 1, rgb.data());
    EXPECT_NEAR(rgb[0], byte, 1) << linear;
  }
}

TEST(Sensor, AGainFollowsTheLightWithinItsLimits) {
  SensorSettings settings;
  settings.target = 0.2;
  settings.gain_min = 0.1;
  settings.gain_max = 5.0;
  const Sensor automatic(settings);
  EXPECT_DOUBLE_EQ(automatic.GainFor(0.4), 0.5);
  EXPECT_DOUBLE_EQ(automatic.GainFor(1e-6), 5.0);
  EXPECT_DOUBLE_EQ(automatic.GainFor(100.0), 0.1);
  settings.automatic = false;
  settings.gain = 1.5;
  EXPECT_DOUBLE_EQ(Sensor(settings).GainFor(0.4), 1.5);
}

}  // namespace
}  // namespace kawara::sim
