#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "vision/stereo/arc_kernel.hpp"
#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/stereo_camera.hpp"

namespace kawara::vision {

/// Where a camera sees the rays of a part of a great circle, given in the frame of another camera
/// at the same place, and which way "up" is there. By the radial table if the camera has one,
/// else by its model's own Project. Refers to the camera. One thread at a time.
class ArcProjector {
 public:
  /// `up`: any direction, in the frame the arcs will be given in.
  ArcProjector(const StereoCamera& camera, const Eigen::Matrix3d& R_camera_frame,
               const Eigen::Vector3d& up);
  /// Rays start * cosine[i] + turn * sine[i]; start and turn are unit vectors across each other.
  void Project(const Eigen::Vector3f& start, const Eigen::Vector3f& turn, const float* cosine,
               const float* sine, std::size_t count, const paper::ArcPixels& out) const;

 private:
  const StereoCamera& camera_;
  Eigen::Matrix3f rotation_;  ///< to the optical frame, or the camera's
  Eigen::Vector3f up_;        ///< in it
};

/// A place of the curve. gap(): the curve leaves what the camera sees and comes back.
struct CurveStep {
  float u_px, v_px;
  float up_u, up_v;  ///< the picture's direction of A's up, any length
  float delta_rad;   ///< the disparity
  static constexpr float kGap = -1000.0F;
  bool gap() const { return u_px == kGap; }
};

/// The epipolar curve in picture B of a ray of camera A, in steps of a pixel: the paper's section
/// 4B. Eqs. (1) to (3), a pixel's ray M, are A's camera model. Eqs. (4) to (6) take it to B's
/// frame: with the full rotation A(psi) A(omega) A(rho) of both poses and the translation T. Eqs.
/// (7), (8), the plane through B's viewpoint, A's viewpoint O' and M': what lies in it and in
/// front is the half great circle cos(delta) M' + sin(delta) t with t the unit vector across M'
/// away from where B goes, from delta = 0, M infinitely far, to M at the nearest range. It is laid
/// through points some pixels apart and straight between those. One thread at a time.
class EpipolarCurve {
 public:
  EpipolarCurve(const StereoCamera& b, const EpipolarPair& pair, double nearest_m);

  /// Angle between the points through which the curve is laid [rad].
  static double KnotSpacing(const StereoCamera& b);

  /// Steps from infinity on, valid until the next call; each part of the curve that B sees begins
  /// at its first knot.
  std::span<const CurveStep> Follow(const Eigen::Vector3f& ray_a);
  /// Angle of the last ray from the baseline [rad].
  double alpha_rad() const { return static_cast<double>(alpha_rad_); }

 private:
  ArcProjector projector_;
  Eigen::Vector3f e0_;  ///< from A to B, in A's camera frame
  float baseline_m_, nearest_m_, spacing_rad_;
  float alpha_rad_ = 0.0F;
  std::vector<float> cosine_, sine_;         ///< of the knots
  std::array<std::vector<float>, 4> knots_;  ///< u, v, up_u, up_v
  std::vector<CurveStep> steps_;
};

}  // namespace kawara::vision
