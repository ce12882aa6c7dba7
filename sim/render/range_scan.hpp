#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/config/constraints.hpp"
#include "sim/render/ray_scene.hpp"

namespace kawara::sim {

/// A planar laser scanner by time of flight. The defaults are a SICK PLS-101: 361 beams over 180
/// degrees, 25 sweeps a second, 50 m, centimetres (drivers/sick.hpp decodes them; SICK's data of
/// its errors were not at hand: the noise is a typical one of the kind and can be set).
struct RangeScannerSettings {
  double field_deg = 180.0;
  double step_deg = 0.5;
  double mirror_period_s = 0.040;  ///< one turn of the mirror; the field takes field / 360 of it
  double max_range_m = 50.0;
  double resolution_m = 0.01;  ///< ranges come in whole steps of this; 0: as measured
  double noise_m = 0.02;       ///< standard deviation of a range near by
  double noise_share = 0.001;  ///< and this share of the range, added in squares
  double beam_rad = 0.0087;    ///< full width of the beam (0.5 degrees: neighbours touch)
  int beam_rays = 7;           ///< rays a beam is averaged over: the centre and a ring; 1: a line
  /// Echo a perfect white surface square to the beam gives at 1 m, in units of the least that is
  /// detected; what comes back falls with the square of the range. 20000: a 10 % target is seen to
  /// 45 m, a 2 % one to 20 m.
  double echo_at_1m = 20000.0;
  double dropout_share = 0.0005;  ///< beams lost for no reason

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("field_deg", field_deg, Range{1, 360}, Optional{});
    v("step_deg", step_deg, Range{0.05, 10}, Optional{});
    v("mirror_period_s", mirror_period_s, Range{0.001, 10}, Optional{});
    v("max_range_m", max_range_m, Range{0.1, 1000}, Optional{});
    v("resolution_m", resolution_m, Range{0, 1}, Optional{});
    v("noise_m", noise_m, Range{0, 1}, Optional{});
    v("noise_share", noise_share, Range{0, 0.1}, Optional{});
    v("beam_rad", beam_rad, Range{0, 0.1}, Optional{});
    v("beam_rays", beam_rays, Range{1, 16}, Optional{});
    v("echo_at_1m", echo_at_1m, Range{1, 1e9}, Optional{});
    v("dropout_share", dropout_share, Range{0, 1}, Optional{});
  }
  int beam_count() const;
};

/// One beam. Angles as drivers::SickScan has them: counter-clockwise seen from above, 0 to the
/// scanner's right, pi/2 ahead.
struct RangeBeam {
  double angle_rad = 0.0;
  double time_s = 0.0;        ///< from the middle of the sweep
  double range_m = 0.0;       ///< as the scanner reports it; max_range_m: nothing came back
  bool echo = false;          ///< something came back
  double true_range_m = 0.0;  ///< of the beam's middle; infinity: the sky
  std::uint32_t object = 0;   ///< in the beam's middle
};

/// Casts sweeps of a scanner into a scene. Immutable; any thread.
class RangeScanner {
 public:
  explicit RangeScanner(const RangeScannerSettings& settings);

  /// A sweep. `enu_from_scanner`: pose (x to the scanner's right, y ahead, z up) as a function of
  /// seconds from mid-sweep, when the beam points ahead; the vehicle moves while the mirror turns.
  /// `time_s` of the mission at mid-sweep. The same seed gives the same sweep.
  ///
  /// A beam has a width: where it meets two surfaces the echoes are averaged by their strength if
  /// they are near each other, or the stronger one wins. Dark, grazing and far surfaces, and glass
  /// off the perpendicular, send back too little and are not seen.
  std::vector<RangeBeam> Scan(const RayScene& scene,
                              const std::function<Eigen::Isometry3d(double)>& enu_from_scanner,
                              double time_s, std::uint64_t seed) const;

  const RangeScannerSettings& settings() const { return settings_; }

 private:
  RangeScannerSettings settings_;
};

}  // namespace kawara::sim
