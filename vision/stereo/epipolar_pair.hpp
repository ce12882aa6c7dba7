#pragma once
#include <Eigen/Geometry>

#include "core/expected.hpp"
#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// Two views and the sphere that both share: its north pole is where A sees B, so every great
/// half-circle from pole to pole (a meridian) is an epipolar line of both. What A sees at the angle
/// alpha from the pole B sees on the same meridian at alpha + delta; delta > 0 is the disparity.
/// Immutable; any thread.
///
/// EPIPOLAR FRAME, the same directions for both views: e0 from A to B; e1 up, as far as that is
/// possible; e2 = e0 x e1. beta is the meridian's angle from e1 towards e2, so that where the
/// meridians' numbers wrap is in the sky.
struct EpipolarPair {
  Eigen::Matrix3d a_from_epipolar = Eigen::Matrix3d::Identity();  ///< to A's camera frame
  Eigen::Matrix3d b_from_epipolar = Eigen::Matrix3d::Identity();  ///< to B's
  double baseline_m = 0.0;

  /// Any metric map frame. kInvalidArgument: the viewpoints are closer than a millimetre.
  static core::Expected<EpipolarPair> FromPoses(const Eigen::Isometry3d& map_from_a,
                                                const Eigen::Isometry3d& map_from_b);

  /// Unit direction in the epipolar frame.
  static Eigen::Vector3d Ray(double alpha_rad, double beta_rad);

  /// Distance from A along its ray at alpha when the disparity is delta (sine rule; OpenCV's
  /// baseline * f / disparity holds for alpha = 90 deg only). Infinite for delta <= 0.
  double Range(double alpha_rad, double delta_rad) const;
  /// The inverse: how far on B sees what A sees at that range.
  double Disparity(double alpha_rad, double range_m) const;
};

/// How sure the step from A to B is; every range of the pair shares these errors.
struct StepDoubt {
  double length_relative_sd = 0.0;  ///< of the baseline, in parts of it
  double turn_sd_rad = 0.0;         ///< of B against A, about any axis
};

}  // namespace kawara::vision
