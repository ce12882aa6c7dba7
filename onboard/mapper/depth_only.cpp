#include "onboard/mapper/depth_only.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include "onboard/mapper/pair_poses.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;

double Median(std::vector<float> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

/// Where the search for things near begins: so many baselines away, but not farther than that [m].
constexpr double kFirstBaselines = 3.0, kFirstNearest = 1.5;
/// Nearer than that, in parts of the distance before, as long as this part of what was found crowds
/// where the search ended: there is something nearer still, and it was taken for something else.
constexpr double kNearer = 0.8, kCrowded = 0.02, kCrowdsWithin = 1.05;
constexpr int kMostSearches = 5;

bool CrowdsAt(double nearest_m, const vision::RangeImage& ranges) {
  std::size_t known = 0, crowding = 0;
  for (const float range_m : ranges.range_m) {
    if (std::isnan(range_m)) continue;
    ++known;
    if (static_cast<double>(range_m) < kCrowdsWithin * nearest_m) ++crowding;
  }
  return static_cast<double>(crowding) > kCrowded * static_cast<double>(known);
}

core::Expected<void> Match(const DepthOptions& options, const vision::StereoView& a,
                           const vision::StereoView& b, const vision::StepDoubt& doubt,
                           vision::RangeImage& ranges) {
  StereoOptions stereo = options.stereo;
  if (!options.find_nearest) return StereoMatcher(stereo).Match(a, b, ranges, doubt);
  const double baseline_m =
      (b.map_from_camera.translation() - a.map_from_camera.translation()).norm();
  stereo.nearest_m = std::min(kFirstNearest, kFirstBaselines * baseline_m);
  for (int search = 1;; ++search) {
    if (auto done = StereoMatcher(stereo).Match(a, b, ranges, doubt); !done) return done;
    if (search == kMostSearches || !CrowdsAt(stereo.nearest_m, ranges)) return {};
    stereo.nearest_m *= kNearer;
  }
}

/// "frames/00007.jpg", as a shell completes it, is the end of the picture's path.
bool EndsWith(const fs::path& file, const fs::path& name) {
  auto part = file.end();
  for (auto wanted = name.end(); wanted != name.begin();) {
    if (part == file.begin() || *--part != *--wanted) return false;
  }
  return true;
}

/// What this program does not yet make of a rig's description.
std::string Unheeded(const survey::SurveyCamera& camera) {
  if (camera.line_delay_s != 0.0) {
    return "the camera has a rolling shutter (line_delay_s): the picture is taken as of one "
           "instant, so ranges are "
           "off where the robot moved or turned during its readout";
  }
  return {};
}

}  // namespace

core::Expected<const survey::SurveyFrame*> FindFrame(const survey::Survey& survey,
                                                     const std::string& name) {
  const survey::SurveyFrame* found = nullptr;
  for (const auto& frame : survey.frames) {
    const std::string full = survey::FullNameOf(survey, frame);
    const bool fits = name == full || name == frame.name || EndsWith(frame.file, name);
    if (!fits) continue;
    if (found != nullptr) {
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "frame '" + name + "' is the name of several pictures: say which, as '" +
                            survey::FullNameOf(survey, *found) + "' or '" + full + "'");
    }
    found = &frame;
  }
  if (found != nullptr) return found;
  std::string names = survey::FullNameOf(survey, survey.frames.front());
  if (survey.frames.size() > 1) {
    names += " ... ";
    names += survey::FullNameOf(survey, survey.frames.back());
  }
  return core::Fail(core::ErrorCode::kNotFound,
                    "no frame '" + name + "' with a pose in the survey; there are " +
                        std::to_string(survey.frames.size()) + ": " + names);
}

core::Expected<DepthResult> RunDepthOnly(const DepthOptions& options) {
  const auto survey = survey::OpenSurvey(options.survey);
  if (!survey) return tl::unexpected(survey.error());
  const auto frame_a = FindFrame(*survey, options.frame_a);
  if (!frame_a) return tl::unexpected(frame_a.error());
  const auto frame_b = FindFrame(*survey, options.frame_b);
  if (!frame_b) return tl::unexpected(frame_b.error());
  const auto picture_a = survey::LoadFrame(*survey, **frame_a);
  if (!picture_a) return tl::unexpected(picture_a.error());
  const auto picture_b = survey::LoadFrame(*survey, **frame_b);
  if (!picture_b) return tl::unexpected(picture_b.error());

  std::vector<std::shared_ptr<const vision::StereoCamera>> cameras(survey->cameras.size());
  for (const auto* frame : {*frame_a, *frame_b}) {
    const auto c = static_cast<std::size_t>(frame->camera);
    const survey::SurveyCamera& camera = survey->cameras[c];
    if (cameras[c] != nullptr) continue;
    cameras[c] = std::make_shared<const vision::StereoCamera>(camera.model, camera.mask);
  }
  PairPoses poses = GivenPairPoses(*survey, **frame_a, **frame_b);
  if (options.refine) {
    auto refined = RefinePairPoses(*survey, **frame_a, **frame_b, cameras);
    if (!refined) return tl::unexpected(refined.error());
    poses = std::move(*refined);
  }
  const auto& camera_a = cameras[static_cast<std::size_t>((*frame_a)->camera)];
  const auto& camera_b = cameras[static_cast<std::size_t>((*frame_b)->camera)];
  const vision::StereoView a{camera_a.get(), picture_a->view(), poses.map_from_a};
  const vision::StereoView b{camera_b.get(), picture_b->view(), poses.map_from_b};

  DepthResult result;
  result.baseline_m = (b.map_from_camera.translation() - a.map_from_camera.translation()).norm();
  result.frames_used = poses.frames_used;
  result.step_change_m = poses.step_change_m;
  result.step_change_rad = poses.step_change_rad;
  result.warning = Unheeded(survey->cameras[static_cast<std::size_t>((*frame_a)->camera)]);
  if (result.warning.empty()) result.warning = poses.warning;
  vision::RangeImage ranges;
  const auto start = std::chrono::steady_clock::now();
  const auto done = Match(options, a, b, poses.doubt, ranges);
  if (!done) return tl::unexpected(done.error());
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::vector<float> known_m, sd_m;
  double seen = 0.0;
  for (std::size_t i = 0; i < ranges.range_m.size(); ++i) {
    if (camera_a->rays().seen(i)) seen += 1.0;
    if (std::isnan(ranges.range_m[i])) continue;
    known_m.push_back(ranges.range_m[i]);
    sd_m.push_back(ranges.sd_m[i]);
  }
  if (known_m.empty()) {
    return core::Fail(
        core::ErrorCode::kFormat,
        "frames '" + options.frame_a + "' and '" + options.frame_b +
            "' show nothing in common that could be measured: check that their poses, the mounting "
            "and "
            "the calibration are of these pictures, or take frames nearer to each other");
  }
  result.known = static_cast<double>(known_m.size()) / seen;
  result.median_range_m = Median(std::move(known_m));
  result.median_sd_m = Median(std::move(sd_m));

  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) {
    return core::Fail(core::ErrorCode::kIo,
                      "make folder " + options.out.string() + ": " + error.message());
  }
  std::string name =
      survey::FullNameOf(*survey, **frame_a) + "_" + survey::FullNameOf(*survey, **frame_b);
  std::replace(name.begin(), name.end(), '/', '-');
  auto files = WriteRangeFiles(ranges, options.out, name);
  if (!files) return tl::unexpected(files.error());
  result.files = std::move(*files);
  return result;
}

}  // namespace kawara::mapper
