#include "onboard/mapper/pair_poses.hpp"

#include <algorithm>
#include <cmath>

#include "vision/refine/pose_refiner.hpp"
#include "vision/refine/so3.hpp"

namespace kawara::mapper {
namespace {

using survey::Survey;
using survey::SurveyFrame;

/// Frames of the window on either side of the pair, and between its two.
constexpr int kBeside = 9;
constexpr int kBetween = 8;
/// Neighbours closer than this show nothing new [m]; the pair's own distance may ask for less.
constexpr double kLeastStep = 0.25;
/// A gap in the drive.
constexpr double kLargestStep = 1.5;
/// Corrections beyond this many of the survey's own deviations are no chance.
constexpr double kSurprise = 5.0;

/// Frames of one moment: a stop of the drive.
struct Stop {
  const Eigen::Isometry3d* pose;
  std::vector<const SurveyFrame*> frames;
};

Eigen::Isometry3d PoseOf(const Survey& survey, const SurveyFrame& frame) {
  return frame.pose.map_from_body *
         survey.cameras[static_cast<std::size_t>(frame.camera)].body_from_camera;
}

bool SameMoment(const SurveyFrame& one, const SurveyFrame& other) {
  return one.pose.map_from_body.isApprox(other.pose.map_from_body, 1e-12);
}

/// All moments in the order of the drive, with the frames of these two cameras.
std::vector<Stop> Stops(const Survey& survey, int camera_a, int camera_b) {
  std::vector<Stop> stops;
  for (const SurveyFrame& frame : survey.frames) {
    if (frame.camera != camera_a && frame.camera != camera_b) continue;
    if (stops.empty() || !SameMoment(*stops.back().frames.front(), frame)) {
      stops.push_back({&frame.pose.map_from_body, {}});
    }
    stops.back().frames.push_back(&frame);
  }
  return stops;
}

double Apart(const Stop& one, const Stop& other) {
  return (one.pose->translation() - other.pose->translation()).norm();
}

std::size_t StopOf(const std::vector<Stop>& stops, const SurveyFrame& frame) {
  for (std::size_t i = 0; i < stops.size(); ++i) {
    if (std::ranges::find(stops[i].frames, &frame) != stops[i].frames.end()) return i;
  }
  return 0;  // not reached: every frame of the two cameras is in one
}

/// Stops from `from` on in steps of at least `step`, up to `count` of them, before a gap.
void Walk(const std::vector<Stop>& stops, std::size_t from, std::ptrdiff_t direction, double step,
          int count, std::vector<std::size_t>& chosen) {
  std::size_t last = from;
  for (auto i = static_cast<std::ptrdiff_t>(from) + direction;
       i >= 0 && i < static_cast<std::ptrdiff_t>(stops.size()) && count > 0; i += direction) {
    const auto here = static_cast<std::size_t>(i);
    const double apart = Apart(stops[last], stops[here]);
    if (apart > kLargestStep) break;
    if (apart < step) continue;
    chosen.push_back(here);
    last = here;
    --count;
  }
}

/// The window: the two stops, some between, some on either side; sorted. The two alone if the way
/// between them is long or has a gap.
std::vector<std::size_t> Window(const std::vector<Stop>& stops, std::size_t first,
                                std::size_t last) {
  const double step = std::min(kLeastStep, 0.45 * Apart(stops[first], stops[last]));
  std::vector<std::size_t> chosen{first};
  bool gap = false;
  for (std::size_t i = first + 1; i < last; ++i) {
    if (Apart(stops[chosen.back()], stops[i]) < step || Apart(stops[i], stops[last]) < step)
      continue;
    gap = gap || Apart(stops[chosen.back()], stops[i]) > kLargestStep;
    chosen.push_back(i);
  }
  if (gap || static_cast<int>(chosen.size()) > kBetween + 1) chosen.resize(1);
  chosen.push_back(last);
  Walk(stops, first, -1, std::max(step, 0.02), kBeside, chosen);
  Walk(stops, last, +1, std::max(step, 0.02), kBeside, chosen);
  std::ranges::sort(chosen);
  return chosen;
}

core::Expected<void> AddStop(const Survey& survey, const Stop& stop,
                             const std::vector<std::size_t>& rig_index,
                             vision::PoseRefiner& refiner) {
  std::vector<survey::Picture> pictures;
  std::vector<vision::RigPicture> views;
  pictures.reserve(stop.frames.size());
  for (const SurveyFrame* frame : stop.frames) {
    auto picture = survey::LoadFrame(survey, *frame);
    if (!picture) return tl::unexpected(picture.error());
    pictures.push_back(std::move(*picture));
    views.push_back({rig_index[static_cast<std::size_t>(frame->camera)], pictures.back().view()});
  }
  const survey::PoseRow& row = stop.frames.front()->pose;
  vision::PriorPose prior{.time = row.time, .map_from_body = row.map_from_body, .covariance = {}};
  if (row.has_covariance) prior.covariance = row.covariance;
  return refiner.Add(prior, views);
}

std::string Surprise(double moved_sd) {
  if (!(moved_sd > kSurprise)) return {};
  return "the pictures contradict the survey's poses by " + std::to_string(std::lround(moved_sd)) +
         " of their deviations: check the mounting, the calibration, the time stamps and the "
         "stated "
         "deviations";
}

}  // namespace

PairPoses GivenPairPoses(const Survey& survey, const SurveyFrame& a, const SurveyFrame& b) {
  PairPoses poses;
  poses.map_from_a = PoseOf(survey, a);
  poses.map_from_b = PoseOf(survey, b);
  if (!a.pose.has_covariance || !b.pose.has_covariance || SameMoment(a, b)) return poses;
  const vision::Matrix6d sum = a.pose.covariance + b.pose.covariance;
  const Eigen::Vector3d step = poses.map_from_b.translation() - poses.map_from_a.translation();
  const double length = std::max(1e-3, step.norm());
  const Eigen::Vector3d along = step / length;
  poses.doubt.length_relative_sd =
      std::sqrt(std::max(0.0, along.dot(sum.topLeftCorner<3, 3>() * along))) / length;
  poses.doubt.turn_sd_rad = std::sqrt(sum.bottomRightCorner<3, 3>().trace() / 3.0);
  return poses;
}

core::Expected<PairPoses> RefinePairPoses(
    const Survey& survey, const SurveyFrame& a, const SurveyFrame& b,
    const std::vector<std::shared_ptr<const vision::StereoCamera>>& cameras) {
  PairPoses poses = GivenPairPoses(survey, a, b);
  if (SameMoment(a, b)) return poses;
  const std::vector<Stop> stops = Stops(survey, a.camera, b.camera);
  const std::size_t at_a = StopOf(stops, a), at_b = StopOf(stops, b);
  const std::vector<std::size_t> window = Window(stops, std::min(at_a, at_b), std::max(at_a, at_b));

  std::vector<vision::RigCamera> rig;
  std::vector<std::size_t> rig_index(survey.cameras.size(), 0);
  for (const int camera : {a.camera, b.camera}) {
    const auto c = static_cast<std::size_t>(camera);
    if (camera == b.camera && !rig.empty() && b.camera == a.camera) continue;
    rig_index[c] = rig.size();
    rig.push_back({cameras[c].get(), survey.cameras[c].body_from_camera});
  }
  vision::PoseRefinerOptions options;
  options.window = static_cast<int>(window.size());
  vision::PoseRefiner refiner(options, rig);
  std::vector<std::size_t> added;
  for (const std::size_t stop : window) {
    if (auto done = AddStop(survey, stops[stop], rig_index, refiner); !done) {
      if (stop == at_a || stop == at_b) return tl::unexpected(done.error());
      continue;  // a neighbour's picture is torn: the others will do
    }
    added.push_back(stop);
  }
  const auto number = [&](std::size_t stop) {
    return static_cast<std::size_t>(std::ranges::find(added, stop) - added.begin());
  };
  const auto body_a = refiner.pose(number(at_a)), body_b = refiner.pose(number(at_b));
  const Eigen::Isometry3d given = poses.map_from_a.inverse() * poses.map_from_b;
  const vision::StepDoubt stated = poses.doubt;
  poses.map_from_a = body_a * survey.cameras[static_cast<std::size_t>(a.camera)].body_from_camera;
  poses.map_from_b = body_b * survey.cameras[static_cast<std::size_t>(b.camera)].body_from_camera;
  poses.doubt = refiner.Doubt(number(at_a), number(at_b));
  poses.frames_used = static_cast<int>(added.size());
  const Eigen::Isometry3d change = given.inverse() * poses.map_from_a.inverse() * poses.map_from_b;
  poses.step_change_m = change.translation().norm();
  poses.step_change_rad = vision::Log(change.linear()).norm();
  const double likely_rad = std::max(stated.turn_sd_rad, options.unstated_attitude_sd_rad);
  poses.warning = Surprise(poses.step_change_rad / (std::sqrt(3.0) * likely_rad));
  return poses;
}

}  // namespace kawara::mapper
