#include "vision/refine/pose_refiner.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "vision/refine/so3.hpp"

namespace kawara::vision {
namespace {

/// No pose is taken to be better than this, whatever it says: pictures and calibration are not.
constexpr double kLeastPositionSd = 2e-4;
constexpr double kLeastAttitudeSd = 0.002 * core::kRadFromDeg;
/// What is believed of a sighting's deviation [px].
constexpr double kLeastRaySd = 0.05, kMostRaySd = 1.0;
/// A corner is followed through this many frames; then its patch has changed too much.
constexpr std::size_t kLongestTrack = 15;

/// A corner that stays where it is in the picture [px], while the horizon moves by more, is of the
/// robot's own body.
constexpr double kStandsStill = 0.35, kHorizonMoved = 1.5;

Matrix6d Floored(Matrix6d covariance) {
  for (int i = 0; i < 6; ++i) {
    const double least = i < 3 ? kLeastPositionSd : kLeastAttitudeSd;
    covariance(i, i) += least * least;
  }
  return covariance;
}

RigInformation InformationOf(const Eigen::Vector4d& sd) {
  return sd.cwiseAbs2().cwiseInverse().asDiagonal();
}

}  // namespace

PoseRefiner::PoseRefiner(const PoseRefinerOptions& options, const std::vector<RigCamera>& rig)
    : options_(options) {
  for (const RigCamera& camera : rig) {
    cameras_.push_back({camera, CornerTracker(options.corners), {}, 0, 0});
  }
  Eigen::Vector4d sd;
  sd << Eigen::Vector3d::Constant(options.mounting_sd_rad), options.time_offset_sd_s;
  rig_information_ = known_rig_information_ = next_rig_information_ = InformationOf(sd);
}

PoseRefiner::Frame PoseRefiner::MakeFrame(const PriorPose& prior) const {
  Frame frame;
  frame.time = prior.time;
  frame.window.prior = prior.map_from_body;
  Matrix6d covariance = Matrix6d::Zero();
  const double position = options_.unstated_position_sd_m;
  const double attitude = options_.unstated_attitude_sd_rad;
  covariance.diagonal() << Eigen::Vector3d::Constant(position * position),
      Eigen::Vector3d::Constant(attitude * attitude);
  frame.window.covariance = Floored(prior.covariance.value_or(covariance));
  frame.pose = frame.window.prior;
  if (!frames_.empty()) {
    // As the frame before was corrected.
    const Frame& last = frames_.back();
    frame.pose = last.pose * last.window.prior.inverse() * frame.window.prior;
  }
  return frame;
}

core::Expected<void> PoseRefiner::Add(const PriorPose& prior,
                                      std::span<const RigPicture> pictures) {
  Frame frame = MakeFrame(prior);
  if (!frames_.empty()) {
    if (auto done = Follow(frame, pictures); !done) return done;
  }
  for (CameraState& camera : cameras_) camera.picture.clear();
  for (const RigPicture& picture : pictures) {
    CameraState& camera = cameras_[picture.camera];
    camera.width_px = picture.picture.width_px;
    camera.height_px = picture.picture.height_px;
    camera.picture.assign(picture.picture.data,
                          picture.picture.data + picture.picture.size_bytes());
  }
  frames_.push_back(std::move(frame));
  if (frames_.size() > static_cast<std::size_t>(options_.window)) DropOldest();
  Motions();
  if (frames_.size() >= 2) Adjust();
  return {};
}

core::Expected<void> PoseRefiner::Follow(const Frame& frame, std::span<const RigPicture> pictures) {
  const std::size_t last = end() - 1;
  std::vector<Track> followed;
  for (const RigPicture& picture : pictures) {
    CORE_CHECK(picture.camera < cameras_.size());
    CameraState& camera = cameras_[picture.camera];
    if (camera.picture.empty()) continue;
    std::vector<std::size_t> alive;
    std::vector<Eigen::Vector3d> rays;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const Sighting& sighting = tracks_[i].point.sightings.back();
      if (!tracks_[i].alive || sighting.camera != picture.camera || sighting.frame != last)
        continue;
      if (tracks_[i].point.sightings.size() >= kLongestTrack && !tracks_[i].rides) continue;
      alive.push_back(i);
      rays.push_back(sighting.ray);
    }
    const StereoView before{camera.rig.camera,
                            {camera.picture.data(), camera.width_px, camera.height_px},
                            frames_.back().pose * camera.rig.body_from_camera};
    const StereoView now{camera.rig.camera, picture.picture,
                         frame.pose * camera.rig.body_from_camera};
    const auto corners = camera.tracker.Track(before, now, rays);
    if (!corners) return tl::unexpected(corners.error());
    px_per_rad_ = camera.tracker.px_per_rad();
    for (const TrackedCorner& corner : *corners) {
      const Sighting there{last + 1, picture.camera, corner.ray_b};
      if (corner.known >= 0) {
        tracks_[alive[static_cast<std::size_t>(corner.known)]].point.sightings.push_back(there);
      } else {
        followed.push_back({{{{last, picture.camera, corner.ray_a}, there}}, true});
      }
    }
  }
  for (Track& track : tracks_) track.alive = track.point.sightings.back().frame == last + 1;
  tracks_.insert(tracks_.end(), followed.begin(), followed.end());
  return {};
}

void PoseRefiner::DropOldest() {
  frames_.pop_front();
  ++first_;
  for (Track& track : tracks_) {
    std::erase_if(track.point.sightings,
                  [this](const Sighting& sighting) { return sighting.frame < first_; });
  }
  std::erase_if(tracks_, [this](const Track& track) {
    return track.point.sightings.empty() ||
           (track.point.sightings.size() < 2 && track.point.sightings.back().frame + 1 < end());
  });
}

// By the turns of the prior: what refinement makes of them may already be the body's doing.
bool PoseRefiner::RidesAlong(const WindowPoint& point) const {
  const auto map_from_camera = [this](const Sighting& sighting) {
    return Eigen::Matrix3d(frames_[sighting.frame - first_].window.prior.linear() *
                           cameras_[sighting.camera].rig.body_from_camera.linear());
  };
  const Sighting& first = point.sightings.front();
  const Eigen::Vector3d far_away = map_from_camera(first) * first.ray;
  double moved = 0.0, horizon = 0.0;
  for (const Sighting& sighting : point.sightings) {
    moved = std::max(moved, (sighting.ray - first.ray).norm());
    horizon =
        std::max(horizon, (map_from_camera(sighting).transpose() * far_away - first.ray).norm());
  }
  return moved * px_per_rad_ < kStandsStill && horizon * px_per_rad_ > kHorizonMoved;
}

/// Velocities and turn rates, from the neighbours in the window.
void PoseRefiner::Motions() {
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Frame& before = frames_[i == 0 ? 0 : i - 1];
    const Frame& after = frames_[std::min(i + 1, frames_.size() - 1)];
    WindowFrame& here = frames_[i].window;
    here.velocity_mps.setZero();
    here.rate_radps.setZero();
    if (!before.time.IsSet() || !after.time.IsSet() || after.time <= before.time) continue;
    const double span_s = core::ToSeconds(after.time - before.time);
    here.velocity_mps = (after.pose.translation() - before.pose.translation()) / span_s;
    here.rate_radps = Log(before.pose.linear().transpose() * after.pose.linear()) / span_s;
  }
}

void PoseRefiner::Adjust() {
  WindowProblem problem;
  std::vector<Eigen::Isometry3d> start;
  for (const Frame& frame : frames_) {
    problem.frames.push_back(frame.window);
    start.push_back(frame.pose);
  }
  for (const CameraState& camera : cameras_) {
    problem.body_from_camera.push_back(camera.rig.body_from_camera);
  }
  std::size_t sightings = 0;
  for (Track& track : tracks_) {
    track.rides = track.rides || RidesAlong(track.point);
    problem.points.emplace_back();
    if (track.rides) continue;  // a point nobody sees
    problem.points.back() = track.point;
    for (Sighting& sighting : problem.points.back().sightings) sighting.frame -= first_;
    sightings += track.point.sightings.size();
  }
  sightings_per_frame_ = static_cast<double>(sightings) / static_cast<double>(frames_.size());
  // Without corners there is no sphere yet, and no use for its scale.
  problem.ray_sd_rad = ray_sd_px_ / std::max(1.0, px_per_rad_);
  const std::size_t window = static_cast<std::size_t>(options_.window);
  const bool whole = end() % window == 0;
  if (whole) {
    known_rig_ = next_rig_;
    known_rig_information_ = next_rig_information_;
  }
  problem.rig = known_rig_;
  problem.rig_information = known_rig_information_;

  const WindowSolution solution = SolveWindow(problem, start);
  for (std::size_t i = 0; i < frames_.size(); ++i) frames_[i].pose = solution.poses[i];
  covariance_ = solution.covariance;
  // A point that contradicts the others is not followed any further.
  for (std::size_t i = tracks_.size(); i-- > 0;) {
    if (!solution.point_used[i] && !tracks_[i].rides && tracks_[i].point.sightings.size() > 2) {
      tracks_.erase(tracks_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  if (solution.ray_rms > 0.0) {
    ray_sd_px_ = std::clamp(ray_sd_px_ * std::sqrt(solution.ray_rms), kLeastRaySd, kMostRaySd);
  }
  rig_ = solution.rig;
  rig_information_ = solution.rig_information;
  if (whole) {
    next_rig_ = solution.rig;
    next_rig_information_ = solution.rig_information;
  }
}

StepDoubt PoseRefiner::Doubt(std::size_t from, std::size_t to) const {
  // T = A^-1 B: its translation R_A' (p_B - p_A), its turn R_A' R_B, linearised in both poses.
  const Eigen::Isometry3d &a = pose(from), &b = pose(to);
  const Eigen::Matrix3d body_from_map = a.linear().transpose();
  const Eigen::Vector3d step = body_from_map * (b.translation() - a.translation());
  Eigen::Matrix<double, 6, 12> by = Eigen::Matrix<double, 6, 12>::Zero();
  by.block<3, 3>(0, 0) = -body_from_map;
  by.block<3, 3>(0, 3) = Skew(step);
  by.block<3, 3>(0, 6) = body_from_map;
  by.block<3, 3>(3, 3) = -Eigen::Matrix3d::Identity();
  by.block<3, 3>(3, 9) = body_from_map * b.linear();
  const auto i = 6 * static_cast<Eigen::Index>(from - first_);
  const auto k = 6 * static_cast<Eigen::Index>(to - first_);
  Eigen::Matrix<double, 12, 12> joint;
  joint << covariance_.block<6, 6>(i, i), covariance_.block<6, 6>(i, k),
      covariance_.block<6, 6>(k, i), covariance_.block<6, 6>(k, k);
  const Matrix6d covariance = by * joint * by.transpose();
  const Eigen::Vector3d along = step.normalized();
  const double length_variance = along.dot(covariance.topLeftCorner<3, 3>() * along);
  return {.length_relative_sd = std::sqrt(std::max(0.0, length_variance)) / step.norm(),
          .turn_sd_rad = std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3.0)};
}

Eigen::Vector4d PoseRefiner::rig_sd() const {
  return rig_information_.inverse().diagonal().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace kawara::vision
