#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "core/config/constraints.hpp"

/// Schema of what the simulated sensors do wrong: each section begins with a named profile, whose
/// figures single keys may then replace. Figures that say "drawn" are deviations of which one value
/// is drawn from the seed for the whole drive, at most twice as large.
namespace kawara::sim {

namespace config = core::config;

/// An instrument's own clock against GPS time: stamp = offset + (1 + skew) time; skew wanders.
struct InstrumentClockConfig {
  double offset_s = 0.0;
  double skew_ppm = 0.0;
  double wander_ppm_per_sqrt_h = 0.0;

  template <class V>
  void Visit(V& v) {
    v("offset_s", offset_s, config::Range{-10.0, 10.0}, config::Optional{});
    v("skew_ppm", skew_ppm, config::Range{-1000.0, 1000.0}, config::Optional{});
    v("wander_ppm_per_sqrt_h", wander_ppm_per_sqrt_h, config::Range{0.0, 100.0},
      config::Optional{});
  }
};

/// Gyros and accelerometers. Profiles: "ideal"; "ahrs400cc-100" and "ahrs400cc-200" (the maker's
/// limits as far as published: angle and velocity random walk, scale 1 %, start-up bias after the
/// unit's own trimming, 8.5 and 12 mg as the most); "typical-mems" (a good unit of that class:
/// random walk 0.8 deg/sqrt(h)).
struct ImuConfig {
  std::string profile = "ideal";
  double rate_hz = 100.0;
  double delay_s = 0.0;  ///< the unit's filters: the sample's interval ends this long before it
  double gyro_range_degps = 150.0;
  double accel_range_g = 3.0;
  double gyro_bias_degps = 0.0;         ///< drawn
  double gyro_instability_degph = 0.0;  ///< Gauss-Markov
  double gyro_instability_tau_s = 300.0;
  double gyro_walk_degph_per_sqrt_h = 0.0;  ///< rate random walk
  double angle_walk_deg_per_sqrt_h = 0.0;   ///< white rate noise
  double gyro_scale = 0.0;                  ///< drawn, share
  double gyro_misalignment = 0.0;           ///< drawn, share of the other axes
  double gyro_g_degps_per_g = 0.0;          ///< drawn, of each axis by each force
  double accel_bias_mg = 0.0;               ///< drawn
  double accel_instability_mg = 0.0;        ///< Gauss-Markov
  double accel_instability_tau_s = 300.0;
  double accel_walk_mg_per_sqrt_h = 0.0;      ///< random walk of the bias
  double velocity_walk_mps_per_sqrt_h = 0.0;  ///< white force noise
  double accel_scale = 0.0;                   ///< drawn
  double accel_misalignment = 0.0;            ///< drawn
  InstrumentClockConfig clock;

  static ImuConfig Named(const std::string& profile);

  template <class V>
  void Visit(V& v) {
    const std::string before = profile;
    v("profile", profile, config::OneOf{"ideal", "ahrs400cc-100", "ahrs400cc-200", "typical-mems"},
      config::Optional{});
    if (profile != before) *this = Named(profile);  // reading; what follows may replace its figures
    v("rate_hz", rate_hz, config::Range{10.0, 1000.0}, config::Optional{});
    v("delay_s", delay_s, config::Range{0.0, 0.5}, config::Optional{});
    v("gyro_range_degps", gyro_range_degps, config::Range{10.0, 5000.0}, config::Optional{});
    v("accel_range_g", accel_range_g, config::Range{1.2, 100.0}, config::Optional{});
    v("gyro_bias_degps", gyro_bias_degps, config::Range{0.0, 10.0}, config::Optional{});
    v("gyro_instability_degph", gyro_instability_degph, config::Range{0.0, 1e4},
      config::Optional{});
    v("gyro_instability_tau_s", gyro_instability_tau_s, config::Range{1.0, 1e5},
      config::Optional{});
    v("gyro_walk_degph_per_sqrt_h", gyro_walk_degph_per_sqrt_h, config::Range{0.0, 1e5},
      config::Optional{});
    v("angle_walk_deg_per_sqrt_h", angle_walk_deg_per_sqrt_h, config::Range{0.0, 100.0},
      config::Optional{});
    v("gyro_scale", gyro_scale, config::Range{0.0, 0.2}, config::Optional{});
    v("gyro_misalignment", gyro_misalignment, config::Range{0.0, 0.2}, config::Optional{});
    v("gyro_g_degps_per_g", gyro_g_degps_per_g, config::Range{0.0, 10.0}, config::Optional{});
    v("accel_bias_mg", accel_bias_mg, config::Range{0.0, 1000.0}, config::Optional{});
    v("accel_instability_mg", accel_instability_mg, config::Range{0.0, 100.0}, config::Optional{});
    v("accel_instability_tau_s", accel_instability_tau_s, config::Range{1.0, 1e5},
      config::Optional{});
    v("accel_walk_mg_per_sqrt_h", accel_walk_mg_per_sqrt_h, config::Range{0.0, 1000.0},
      config::Optional{});
    v("velocity_walk_mps_per_sqrt_h", velocity_walk_mps_per_sqrt_h, config::Range{0.0, 100.0},
      config::Optional{});
    v("accel_scale", accel_scale, config::Range{0.0, 0.2}, config::Optional{});
    v("accel_misalignment", accel_misalignment, config::Range{0.0, 0.2}, config::Optional{});
    v("clock", clock, config::Optional{});
  }
};

/// The magnetometer on a vehicle of steel, in the Earth's field of the site. Profiles: "ideal",
/// "on-robot" (after the unit's own hard and soft iron calibration: what that leaves).
struct MagnetometerConfig {
  std::string profile = "ideal";
  double declination_deg = 7.7;  ///< of the site, east positive
  double dip_deg = 49.0;
  double field_gauss = 0.46;
  double hard_iron_gauss = 0.0;  ///< drawn, each axis
  double soft_iron = 0.0;        ///< drawn, each of nine shares
  double noise_gauss = 0.0;

  static MagnetometerConfig Named(const std::string& profile);

  template <class V>
  void Visit(V& v) {
    const std::string before = profile;
    v("profile", profile, config::OneOf{"ideal", "on-robot"}, config::Optional{});
    if (profile != before) *this = Named(profile);
    v("declination_deg", declination_deg, config::Range{-180.0, 180.0}, config::Optional{});
    v("dip_deg", dip_deg, config::Range{-90.0, 90.0}, config::Optional{});
    v("field_gauss", field_gauss, config::Range{0.11, 0.99}, config::Optional{});
    v("hard_iron_gauss", hard_iron_gauss, config::Range{0.0, 1.0}, config::Optional{});
    v("soft_iron", soft_iron, config::Range{0.0, 0.5}, config::Optional{});
    v("noise_gauss", noise_gauss, config::Range{0.0, 0.1}, config::Optional{});
  }
};

/// Wheel encoders, one a side. Profiles: "ideal", "skid-steer", "car".
struct OdometryConfig {
  std::string profile = "ideal";
  double rate_hz = 20.0;
  double ticks_per_m = 1000.0;
  double scale = 0.0;              ///< drawn, of each side: wheel radius, tyre pressure
  double slip = 0.0;               ///< driven wheels turn this share further than they go, mean
  double turn_slip = 0.0;          ///< the same for the share of motion that is turning
  double slip_bursts_per_min = 0;  ///< a side spins on loose ground
  double slip_burst_share = 0.0;   ///< how much further it then turns, mean
  double skids_per_min = 0.0;      ///< a side stands still while the vehicle moves on
  double event_s = 0.6;            ///< length of bursts and skids, mean
  InstrumentClockConfig clock;

  static OdometryConfig Named(const std::string& profile);

  template <class V>
  void Visit(V& v) {
    const std::string before = profile;
    v("profile", profile, config::OneOf{"ideal", "skid-steer", "car"}, config::Optional{});
    if (profile != before) *this = Named(profile);
    v("rate_hz", rate_hz, config::Range{1.0, 200.0}, config::Optional{});
    v("ticks_per_m", ticks_per_m, config::Range{1.0, 1e6}, config::Optional{});
    v("scale", scale, config::Range{0.0, 0.2}, config::Optional{});
    v("slip", slip, config::Range{0.0, 0.9}, config::Optional{});
    v("turn_slip", turn_slip, config::Range{0.0, 0.9}, config::Optional{});
    v("slip_bursts_per_min", slip_bursts_per_min, config::Range{0.0, 60.0}, config::Optional{});
    v("slip_burst_share", slip_burst_share, config::Range{0.0, 5.0}, config::Optional{});
    v("skids_per_min", skids_per_min, config::Range{0.0, 60.0}, config::Optional{});
    v("event_s", event_s, config::Range{0.05, 10.0}, config::Optional{});
    v("clock", clock, config::Optional{});
  }
};

}  // namespace kawara::sim
