#pragma once
#include "estimation/nav_types.hpp"
#include "estimation/navigation_stats.hpp"
#include "estimation/sensor_profile.hpp"

namespace kawara::estimation {

/// Keeps inertial samples out that cannot be: NaN, beyond the range, twice the same time, time
/// running backwards. A lone spike takes the values of the sample before. One thread.
class SampleGate {
 public:
  enum class Result { kPass, kDrop, kRestart };

  /// May replace the values. kRestart: the clock was set back for good.
  Result Pass(ImuSample& sample, const ImuNoise& noise, NavigationStats& stats);

 private:
  ImuSample last_;     ///< as passed on
  ImuSample suspect_;  ///< as measured, if it was replaced
  bool has_last_ = false;
  bool has_suspect_ = false;
  int backwards_in_row_ = 0;
};

}  // namespace kawara::estimation
