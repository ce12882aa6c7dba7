#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "estimation/navigation_filter.hpp"
#include "estimation/navigator.hpp"
#include "estimation/rotation.hpp"
#include "tests/support/drive_recording.hpp"

/// Recordings into a Navigator, and its answers against the truth.
namespace kawara::testing {

inline void Give(estimation::Navigator& navigator, const DriveRecording& drive,
                 const DriveRecording::Arrival& arrival) {
  switch (arrival.kind) {
    case DriveRecording::Kind::kFix:
      navigator.AddFix(drive.fixes[arrival.index]);
      break;
    case DriveRecording::Kind::kWheels:
      navigator.AddOdometry(drive.wheels[arrival.index]);
      break;
    case DriveRecording::Kind::kImu:
      navigator.AddImu(drive.imu[arrival.index]);
      break;
  }
}

/// All in order; after each inertial sample `on_sample(index)`.
template <class OnSample>
void Play(const DriveRecording& drive, estimation::Navigator& navigator, OnSample&& on_sample) {
  for (const auto& arrival : drive.InOrder()) {
    Give(navigator, drive, arrival);
    if (arrival.kind == DriveRecording::Kind::kImu) on_sample(arrival.index);
  }
}
inline void Play(const DriveRecording& drive, estimation::Navigator& navigator) {
  Play(drive, navigator, [](std::size_t) {});
}

/// Truth minus estimate: north, east, down.
inline Eigen::Vector3d PositionError(const estimation::NavKinematics& solution,
                                     const Truth& truth) {
  return estimation::Displacement(solution.position, truth.position);
}
/// Rotation vector in NED that takes the estimate to the truth [rad].
inline Eigen::Vector3d AttitudeError(const estimation::NavKinematics& solution,
                                     const Truth& truth) {
  const Eigen::Quaterniond estimate(core::RotationNedFromBody(solution.attitude));
  return estimation::RotationVector(truth.ned_from_body * estimate.conjugate());
}

/// Root mean square of what is added.
class Rms {
 public:
  void Add(double value) {
    sum_ += value * value;
    ++count_;
  }
  double value() const { return count_ > 0 ? std::sqrt(sum_ / count_) : 0.0; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

}  // namespace kawara::testing
