#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace kawara::sim {

/// Where the camera is during an exposure: its pose at 17 instants evenly spread over it, for each
/// row if the shutter rolls. Immutable; any thread.
class ShutterPoses {
 public:
  static constexpr int kHalf = 8;  ///< instants are numbered -8..8; 0 is the middle

  struct Pose {
    Eigen::Matrix3d R_enu_camera;
    Eigen::Vector3d origin_enu_m;
    /// Takes directions of this instant to the middle one's, and this instant's viewpoint there
    /// [m].
    Eigen::Matrix3f R_middle_this;
    Eigen::Vector3f from_middle_m;

    /// Where the middle instant sees what this one sees `range_m` away (infinity: the sky).
    Eigen::Vector3f SeenFromMiddle(const Eigen::Vector3f& ray, float range_m) const {
      return (R_middle_this * ray + from_middle_m / range_m).normalized();
    }
    /// The reverse.
    Eigen::Vector3f SeenFromHere(const Eigen::Vector3f& middle_ray, float range_m) const {
      return (R_middle_this.transpose() * (middle_ray - from_middle_m / range_m)).normalized();
    }
  };

  ShutterPoses(const std::function<Eigen::Isometry3d(double)>& enu_from_camera, double exposure_s,
               double readout_s, int rows)
      : rolling_(readout_s != 0.0 && rows > 1), rows_(rolling_ ? rows : 1) {
    poses_.reserve(static_cast<std::size_t>(rows_) * kInstants);
    for (int row = 0; row < rows_; ++row) {
      const double middle_s =
          rolling_ ? readout_s * (static_cast<double>(row) / (rows - 1) - 0.5) : 0.0;
      for (int k = -kHalf; k <= kHalf; ++k) {
        if (exposure_s == 0.0 && k > -kHalf) {
          poses_.push_back(poses_.back());
          continue;
        }
        const Eigen::Isometry3d pose = enu_from_camera(middle_s + exposure_s * k / kInstants);
        poses_.push_back({pose.linear(), pose.translation(), {}, {}});
      }
      const std::size_t first = poses_.size() - kInstants;
      const Pose middle = poses_[first + kHalf];
      for (std::size_t i = first; i < poses_.size(); ++i) {
        Pose& pose = poses_[i];
        const Eigen::Matrix3d R_camera_enu = middle.R_enu_camera.transpose();
        pose.R_middle_this = (R_camera_enu * pose.R_enu_camera).cast<float>();
        pose.from_middle_m =
            (R_camera_enu * (pose.origin_enu_m - middle.origin_enu_m)).cast<float>();
      }
    }
  }

  const Pose& At(int row, int instant) const {
    return poses_[static_cast<std::size_t>(rolling_ ? row : 0) * kInstants +
                  static_cast<std::size_t>(kHalf + instant)];
  }
  /// Instant of the i-th of `pairs` pairs of samples (their number: 2 pairs + 1), i = 1..pairs.
  static int InstantOf(int i, int pairs) {
    return std::min(
        kHalf, static_cast<int>(std::lround(static_cast<double>(i * kInstants) / (2 * pairs + 1))));
  }

 private:
  static constexpr int kInstants = 2 * kHalf + 1;
  bool rolling_;
  int rows_;
  std::vector<Pose> poses_;
};

}  // namespace kawara::sim
