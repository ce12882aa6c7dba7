#include "sim/vehicle/sensor_config.hpp"

namespace kawara::sim {

ImuConfig ImuConfig::Named(const std::string& profile) {
  ImuConfig c;
  c.profile = profile;
  if (profile == "ideal") return c;
  // The AHRS400 series: bandwidth above 25 Hz (so some 6 ms of delay), scale below 1 %, bias of the
  // gyros after the unit's own trimming below 0.05 deg/s. Instability and walks are no maker's
  // figures but those usual for silicon gyros of its time.
  c.delay_s = 0.006;
  c.gyro_bias_degps = 0.05;
  c.gyro_instability_degph = 20.0;
  c.gyro_walk_degph_per_sqrt_h = 60.0;
  c.angle_walk_deg_per_sqrt_h = 2.25;
  c.gyro_scale = 0.004;
  c.gyro_misalignment = 0.002;
  c.gyro_g_degps_per_g = 0.02;
  c.accel_bias_mg = 4.0;
  c.accel_instability_mg = 0.3;
  c.accel_walk_mg_per_sqrt_h = 0.5;
  c.velocity_walk_mps_per_sqrt_h = 0.1;
  c.accel_scale = 0.004;
  c.accel_misalignment = 0.002;
  if (profile == "ahrs400cc-200") {
    c.gyro_range_degps = 300.0;
    c.accel_range_g = 6.0;
    c.angle_walk_deg_per_sqrt_h = 4.5;
    c.accel_bias_mg = 6.0;
    c.velocity_walk_mps_per_sqrt_h = 0.15;
  } else if (profile == "typical-mems") {
    c.angle_walk_deg_per_sqrt_h = 0.8;
    c.gyro_instability_degph = 10.0;
    c.gyro_walk_degph_per_sqrt_h = 30.0;
    c.gyro_scale = 0.002;
    c.accel_bias_mg = 2.0;
    c.velocity_walk_mps_per_sqrt_h = 0.06;
  }
  return c;
}

MagnetometerConfig MagnetometerConfig::Named(const std::string& profile) {
  MagnetometerConfig c;
  c.profile = profile;
  if (profile == "ideal") return c;
  c.hard_iron_gauss = 0.006;
  c.soft_iron = 0.01;
  c.noise_gauss = 0.0027;  // as measured on a real AHRS400 at rest
  return c;
}

OdometryConfig OdometryConfig::Named(const std::string& profile) {
  OdometryConfig c;
  c.profile = profile;
  if (profile == "ideal") return c;
  c.clock.skew_ppm = 25.0;
  if (profile == "car") {
    c.ticks_per_m = 50.0;  // 96 slots on a wheel of 2 m
    c.scale = 0.005;
    c.slip = 0.002;
    c.skids_per_min = 0.1;
    return c;
  }
  c.scale = 0.01;
  c.slip = 0.02;
  c.turn_slip = 0.08;  // a skid-steer drags its wheels sideways in every turn
  c.slip_bursts_per_min = 1.0;
  c.slip_burst_share = 0.3;
  c.skids_per_min = 0.3;
  return c;
}

}  // namespace kawara::sim
