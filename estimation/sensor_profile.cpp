#include "estimation/sensor_profile.hpp"

#include <array>

#include "core/geodesy.hpp"

namespace kawara::estimation {
namespace {

constexpr double RadRtS(double deg_rt_h) { return deg_rt_h * core::kRadFromDeg / 60.0; }
constexpr double MpsRtS(double mps_rt_h) { return mps_rt_h / 60.0; }
constexpr double RadPerS(double deg_s) { return deg_s * core::kRadFromDeg; }
constexpr double MilliG(double mg) { return mg * 9.80665e-3; }

/// Data sheets: Crossbow AHRS400CC (6020-0025), TDK MPU-6050/ICM-20602 class, Analog Devices
/// ADIS16465. Bias wander is that of a robot's day outdoors, a few times the Allan floor;
/// velocity random walk of the consumer class includes the vibration of a vehicle.
constexpr std::array<SensorProfile, 3> kProfiles = {{
    {"ahrs400cc-100",
     "Crossbow AHRS400CC-100/-200, VG400: fluxgate-era MEMS, 2.25 deg/rt-h",
     {.gyro_arw_rad_rts = RadRtS(2.25),
      .accel_vrw_mps_rts = MpsRtS(0.1),
      .gyro_bias_radps = RadPerS(0.5),
      .accel_bias_mps2 = MilliG(8.5),
      .gyro_bias_rw = 2.0e-5,
      .accel_bias_rw = 2.0e-4,
      .gyro_scale = 0.01,
      .accel_scale = 0.005,
      .gyro_misalignment = 0.008,
      .accel_misalignment = 0.01,
      .gyro_range_radps = RadPerS(220.0),
      .accel_range_mps2 = 45.0}},
    {"consumer-mems",
     "MPU-6050, ICM-20602, BMI-088, LSM6 class: phones, autopilots, GNSS modules",
     {.gyro_arw_rad_rts = RadRtS(0.5),
      .accel_vrw_mps_rts = MpsRtS(0.6),
      .gyro_bias_radps = RadPerS(1.0),
      .accel_bias_mps2 = MilliG(30.0),
      .gyro_bias_rw = 5.0e-5,
      .accel_bias_rw = 3.0e-4,
      .gyro_scale = 0.01,
      .accel_scale = 0.01,
      .gyro_misalignment = 0.02,  // "cross-axis sensitivity" of the data sheets
      .accel_misalignment = 0.01,
      .gyro_range_radps = RadPerS(2000.0),
      .accel_range_mps2 = 160.0}},
    {"industrial-mems",
     "ADIS16465/16470/16500, STIM, HG4930 class: factory-calibrated",
     {.gyro_arw_rad_rts = RadRtS(0.15),
      .accel_vrw_mps_rts = MpsRtS(0.05),
      .gyro_bias_radps = RadPerS(0.15),
      .accel_bias_mps2 = MilliG(5.0),
      .gyro_bias_rw = 3.0e-6,
      .accel_bias_rw = 5.0e-5,
      .gyro_scale = 0.002,
      .accel_scale = 0.002,
      .gyro_misalignment = 0.001,
      .accel_misalignment = 0.001,
      .gyro_range_radps = RadPerS(2000.0),
      .accel_range_mps2 = 160.0}},
}};

}  // namespace

std::span<const SensorProfile> SensorProfiles() { return kProfiles; }

std::optional<ImuNoise> FindSensorProfile(std::string_view name) {
  for (const SensorProfile& profile : kProfiles) {
    if (profile.name == name) return profile.noise;
  }
  return std::nullopt;
}

}  // namespace kawara::estimation
