#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace kawara::vision {

/// What is common to all frames of a drive: how the camera rig is turned against the body that the
/// poses are of (a small turn about the body's axes [rad]), and how much later the pictures were
/// taken than their poses' stamps say [s].
struct RigState {
  Eigen::Vector3d mounting_rad = Eigen::Vector3d::Zero();
  double time_offset_s = 0.0;
};

/// Parameters of a frame in the order position [m, map axes], small turn [rad, body axes].
using Matrix6d = Eigen::Matrix<double, 6, 6>;
/// Mounting, then time offset.
using RigInformation = Eigen::Matrix4d;

/// A frame of the window: what GPS/INS say of it, and how it moves (for the time offset).
struct WindowFrame {
  Eigen::Isometry3d prior = Eigen::Isometry3d::Identity();  ///< map_from_body
  Matrix6d covariance = Matrix6d::Zero();                   ///< of prior; positive definite
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();   ///< map axes
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();     ///< body axes
};

/// A point seen from `frame` along `ray` (unit, camera frame).
struct Sighting {
  std::size_t frame = 0;
  std::size_t camera = 0;
  Eigen::Vector3d ray;
};

/// A point of the world seen twice or more.
struct WindowPoint {
  std::vector<Sighting> sightings;
};

/// A bundle adjustment of few frames with a prior on every pose: the relative motion comes from the
/// pictures, the absolute place and the length of the baselines from RTK.
struct WindowProblem {
  std::vector<WindowFrame> frames;
  std::vector<Eigen::Isometry3d> body_from_camera;
  std::vector<WindowPoint> points;
  double ray_sd_rad = 1e-3;  ///< of a sighting, each way across the ray
  RigState rig;              ///< known before, and how well: rig_information
  RigInformation rig_information = RigInformation::Zero();
};

struct WindowSolution {
  /// map_from_body as the pictures are to be used with: the mounting's and the time's errors are
  /// in it, so that map_from_camera = pose * body_from_camera.
  std::vector<Eigen::Isometry3d> poses;
  /// Of all frames together, [6 n][6 n] in the order of WindowFrame::covariance.
  Eigen::MatrixXd covariance;
  RigState rig;
  RigInformation rig_information = RigInformation::Zero();  ///< of `rig` after this window
  std::vector<bool> point_used;  ///< false: contradicts the rest, or seen once
  double ray_rms = 0.0;          ///< of sightings used, in parts of ray_sd_rad
  int iterations = 0;
};

/// Robust least squares (Gauss and Newton, damped; points are eliminated one by one). `start`:
/// poses to begin from, one a frame; empty: the priors. Reentrant.
WindowSolution SolveWindow(const WindowProblem& problem,
                           const std::vector<Eigen::Isometry3d>& start = {});

}  // namespace kawara::vision
