#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/motion/motion_track.hpp"
#include "sim/motion/recording.hpp"

namespace kawara::sim {

/// What an attitude unit would have measured and worked out at one recorded inertial sample. Sensor
/// axes forward, right, down.
struct AhrsState {
  core::GpsTime time;  ///< as recorded
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d magnetic_gauss = Eigen::Vector3d::Zero();
  core::Attitude attitude;  ///< yaw is MAGNETIC heading
};

/// A coarse attitude filter, causal, as such units have inside: gyro integration pulled towards
/// gravity (only while the specific force is near 1 g) and towards the magnetic heading. One
/// thread.
class CoarseAttitudeFilter {
 public:
  void Update(double dt_s, const AhrsState& sample);
  const core::Attitude& attitude() const { return attitude_; }

 private:
  core::Attitude attitude_;
  bool started_ = false;
};

/// The whole recording as an attitude unit sees it. Rates and forces are the recorded ones,
/// untouched. Two things are MADE where the recording does not hold them, and are no better than
/// this:
///  * the magnetic field (a simulated drive brings its own): the Earth's field of the site turned
///  into the body by the track's yaw (see MotionTrack) and the
///    filter's roll and pitch, plus noise as measured on a real AHRS400 at rest (2.7 mgauss);
///  * the attitude: CoarseAttitudeFilter run over all of it.
std::vector<AhrsState> MakeAhrsTrace(const Recording& recording, const MotionTrack& track,
                                     std::uint64_t seed);

}  // namespace kawara::sim
