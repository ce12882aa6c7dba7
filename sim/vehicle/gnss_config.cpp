#include "sim/vehicle/gnss_config.hpp"

namespace kawara::sim {

GnssConfig GnssConfig::Named(const std::string& profile) {
  GnssConfig c;
  c.profile = profile;
  if (profile == "ideal") return c;
  // Sizes for a dilution of 1: ordinary figures of short-baseline dual frequency RTK and of the
  // worse solutions it falls back to. The wander of a fixed solution is multipath at antenna and
  // base, which repeats over minutes and is why RTK noise is not white.
  c.fixed = {.white_m = 0.005, .wander_m = 0.010, .tau_s = 90.0};
  c.floating = {.white_m = 0.01, .wander_m = 0.10, .tau_s = 60.0};
  c.differential = {.white_m = 0.15, .wander_m = 0.45, .tau_s = 90.0};
  c.autonomous = {.white_m = 0.3, .wander_m = 1.2, .tau_s = 240.0};
  c.float_start_m = 0.6;
  c.fix_time_s = 20.0;
  c.wrong_fix_share = 0.05;
  c.phase_multipath_m = 0.015;
  c.code_multipath_m = 1.5;
  c.velocity_white_mps = 0.025;
  return c;
}

}  // namespace kawara::sim
