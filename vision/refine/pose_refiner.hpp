#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "vision/refine/corner_tracker.hpp"
#include "vision/refine/window_problem.hpp"

namespace kawara::vision {

struct PoseRefinerOptions {
  int window = 21;  ///< frames that are adjusted together; at a quarter of a metre each, 5 m
  CornerTrackerOptions corners = {};
  /// How well mounting and time of the pictures are known before the drive, each axis.
  double mounting_sd_rad = 0.1 * core::kRadFromDeg;
  double time_offset_sd_s = 0.01;
  /// Of a frame that states no covariance.
  double unstated_position_sd_m = 0.02;
  double unstated_attitude_sd_rad = 0.1 * core::kRadFromDeg;
};

/// A camera on the robot. Refers to the StereoCamera.
struct RigCamera {
  const StereoCamera* camera = nullptr;
  Eigen::Isometry3d body_from_camera = Eigen::Isometry3d::Identity();
};

struct RigPicture {
  std::size_t camera = 0;  ///< which of the rig
  ConstImageView picture;
};

/// What goes into the window.
struct PriorPose {
  core::GpsTime time;  ///< of the pictures; not set: the time offset stays as it is
  Eigen::Isometry3d map_from_body = Eigen::Isometry3d::Identity();
  std::optional<Matrix6d> covariance;  ///< position in map axes [m^2], small turns in body axes
};

/// Poses good enough for pixels: GPS/INS says where the robot is, but not to the hundredth of a
/// degree and the millimetre that stereo between two frames wants. Corners followed through the
/// pictures say how the frames stand to each other; a window of them is adjusted with the GPS/INS
/// poses as the prior (window_problem.hpp), so that lengths and the absolute place stay RTK's. The
/// mounting's turn and the pictures' time offset are learnt over the drive. Corners of the robot's
/// own body, which stand still in the picture while the robot turns, say nothing and are left out.
///
/// Frames are numbered from 0 in the order they come, which should be steps of some decimetres; a
/// frame's pose is best once it is in the middle of the window. Keeps a copy of the last pictures.
/// One thread at a time.
class PoseRefiner {
 public:
  PoseRefiner(const PoseRefinerOptions& options, const std::vector<RigCamera>& rig);

  /// One frame with the pictures taken then. kInvalidArgument: not from another place than the
  /// frame before; then it was not taken in.
  core::Expected<void> Add(const PriorPose& prior, std::span<const RigPicture> pictures);

  /// Frames [first(), end()) have poses.
  std::size_t first() const { return first_; }
  std::size_t end() const { return first_ + frames_.size(); }
  /// map_from_body of a frame in the window, refined. Poses of one moment fit each other; what the
  /// next Add makes of them may be moved as a whole.
  const Eigen::Isometry3d& pose(std::size_t frame) const { return frames_[frame - first_].pose; }
  /// Of the step between two frames in the window.
  StepDoubt Doubt(std::size_t from, std::size_t to) const;

  /// Learnt up to now; see RigState. `rig_sd`: mounting's three axes [rad], time offset [s].
  const RigState& rig() const { return rig_; }
  Eigen::Vector4d rig_sd() const;
  double ray_sd_px() const { return ray_sd_px_; }
  /// Sightings the last adjustment rested on, a frame.
  double sightings_per_frame() const { return sightings_per_frame_; }

 private:
  struct Frame {
    core::GpsTime time;
    WindowFrame window;
    Eigen::Isometry3d pose;
  };
  struct Track {
    WindowPoint point;  ///< frames by their number in the drive
    bool alive = true;
    bool rides = false;  ///< is of the robot itself
  };
  struct CameraState {
    RigCamera rig;
    CornerTracker tracker;
    std::vector<std::uint8_t> picture;  ///< of the last frame; empty: it had none
    int width_px = 0, height_px = 0;
  };

  Frame MakeFrame(const PriorPose& prior) const;
  core::Expected<void> Follow(const Frame& frame, std::span<const RigPicture> pictures);
  bool RidesAlong(const WindowPoint& point) const;
  void Motions();
  void Adjust();
  void DropOldest();
  void LearnRig(const WindowSolution& solution);

  PoseRefinerOptions options_;
  std::vector<CameraState> cameras_;
  std::deque<Frame> frames_;
  std::size_t first_ = 0;
  std::vector<Track> tracks_;
  double ray_sd_px_ = 0.3;
  double px_per_rad_ = 0.0;
  double sightings_per_frame_ = 0.0;
  Eigen::MatrixXd covariance_;
  RigState rig_;
  RigInformation rig_information_;  ///< of rig_, for who asks
  RigState known_rig_, next_rig_;   ///< of windows that share no frame with this one;
  RigInformation known_rig_information_, next_rig_information_;  ///< known: now, next: in a window
};

}  // namespace kawara::vision
