#include "tools/calibrate/mounting_run.hpp"

#include <algorithm>
#include <memory>

#include "core/config/writer.hpp"
#include "onboard/mapper/survey_source.hpp"
#include "onboard/survey/survey.hpp"
#include "tools/calibrate/printed.hpp"
#include "tools/navigate/safe_file.hpp"
#include "vision/refine/pose_refiner.hpp"
#include "vision/refine/so3.hpp"

namespace kawara::calibrate {
namespace {

using core::ErrorCode;
using core::Fail;

constexpr int kMostPasses = 5;
/// Of frames adjusted together: the longer, the better RTK says which way the drive went.
constexpr int kWindow = 41;
/// A pass that turns the rig by less about each axis ends it: either [rad], or in deviations.
constexpr double kSettled = 0.005 * core::kRadFromDeg;
constexpr double kSettledShare = 0.5;
/// Frames below which nothing is tried: a window is 21.
constexpr int kLeastFrames = 21;
/// Steps longer than this do not show the same things.
constexpr double kLargestStep = 1.5;
/// Corners that fit no better were not followed, or the calibration is another camera's [px].
constexpr double kPoorPx = 0.9;
constexpr const char* kAxes[] = {"forward", "side", "vertical"};

using Cameras = std::vector<std::unique_ptr<vision::StereoCamera>>;

/// One time along the drive with the rig as it is taken to be.
core::Expected<vision::RigState> Pass(const survey::Survey& survey, const Cameras& cameras,
                                      const MountingOptions& options, MountingResult& result) {
  vision::PoseRefinerOptions refining;
  refining.window = kWindow;
  refining.mounting_sd_rad = options.believed_deg * core::kRadFromDeg;
  std::vector<vision::RigCamera> rig;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    rig.push_back({cameras[i].get(), result.cameras[i].body_from_camera});
  }
  vision::PoseRefiner refiner(refining, rig);
  mapper::SurveySource source(survey);
  result.frames = 0;
  result.way_m = 0.0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (;;) {
    auto stop = source.Next();
    if (!stop) return tl::unexpected(stop.error());
    if (!*stop) break;
    const Eigen::Vector3d here = (*stop)->map_from_body.translation();
    const double step = (here - last).norm();
    if (result.frames > 0 && step < options.step_m) continue;
    if (result.frames > 0 && step > kLargestStep) {
      return Fail(
          ErrorCode::kFormat,
          Printed("%s: %.1f m between frames %s and the one used before: a mounting needs a "
                  "drive without gaps, a picture every %.1f m",
                  options.survey.c_str(), step, (*stop)->pictures.front().name.c_str(),
                  options.step_m));
    }
    std::vector<mapper::SharedPicture> kept;
    std::vector<vision::RigPicture> views;
    for (const mapper::StopPicture& picture : (*stop)->pictures) {
      auto loaded = picture.load();
      if (!loaded) return tl::unexpected(loaded.error());
      kept.push_back(std::move(*loaded));
      views.push_back({picture.camera, kept.back()->view()});
    }
    const vision::PriorPose prior{.time = (*stop)->time,
                                  .map_from_body = (*stop)->map_from_body,
                                  .covariance = (*stop)->covariance};
    if (auto done = refiner.Add(prior, views); !done) return tl::unexpected(done.error());
    if (result.frames > 0) result.way_m += step;
    last = here;
    ++result.frames;
  }
  if (result.frames < kLeastFrames) {
    return Fail(ErrorCode::kFormat,
                Printed("%s: %d frames %.2f m and more apart; a mounting needs %d or more, along a "
                        "drive with curves to both sides",
                        options.survey.c_str(), result.frames, options.step_m, kLeastFrames));
  }
  const Eigen::Vector4d sd = refiner.rig_sd();
  result.turn_sd_rad = sd.head<3>();
  result.time_offset_s = refiner.rig().time_offset_s;
  result.time_offset_sd_s = sd(3);
  result.residual_px = refiner.ray_sd_px();
  return refiner.rig();
}

core::Expected<void> Judge(const MountingOptions& options, const MountingResult& result) {
  if (result.residual_px > kPoorPx) {
    return Fail(ErrorCode::kFormat,
                Printed("%s: pictures and poses contradict each other (corners miss by %.1f px and "
                        "more): is it this camera's calibration, and the poses' axes and stamps?",
                        options.survey.c_str(), result.residual_px));
  }
  std::string loose;
  for (int axis = 0; axis < 3; ++axis) {
    const double sd_deg = result.turn_sd_rad(axis) / core::kRadFromDeg;
    if (sd_deg <= options.wanted_sd_deg) continue;
    loose += Printed("%s%s axis +- %.2f deg", loose.empty() ? "" : ", ", kAxes[axis], sd_deg);
  }
  if (loose.empty()) return {};
  return Fail(ErrorCode::kFormat,
              Printed("%s: this drive does not determine the mounting (turn about the %s): drive "
                      "longer, %d frames over %.0f m were used, and with curves to both sides",
                      options.survey.c_str(), loose.c_str(), result.frames, result.way_m));
}

/// What goes into camera.yaml in the place of its mounting.
std::string FileOf(const MountingResult& result, survey::BodyAxes body) {
  const Eigen::Vector3d turn = result.turn_rad / core::kRadFromDeg;
  const Eigen::Vector3d sd = result.turn_sd_rad / core::kRadFromDeg;
  std::string file = Printed(
      "# By kawara-calibrate mounting from %d frames over %.1f m. Turned from the mounting given "
      "by\n"
      "# %.3f %.3f %.3f deg (+- %.3f %.3f %.3f) about the body's axes; pictures are %.1f ms\n"
      "# (+- %.1f) later than their stamps say (time_offset_s is not changed here).\n",
      result.frames, result.way_m, turn.x(), turn.y(), turn.z(), sd.x(), sd.y(), sd.z(),
      1e3 * result.time_offset_s, 1e3 * result.time_offset_sd_s);
  core::config::Writer axes;
  axes("body_axes", body);
  file += "# For camera.yaml, with its " + axes.text();
  for (const CameraMounting& camera : result.cameras) {
    if (!camera.name.empty()) file += "# camera " + camera.name + "\n";
    const Eigen::Quaterniond q(camera.body_from_camera.linear());
    survey::MountingConfig mounting;
    mounting.translation_m = camera.body_from_camera.translation();
    file += "mounting:\n";
    const auto& t = mounting.translation_m;
    file += Printed("  translation_m: [%.6f, %.6f, %.6f]\n", t.x(), t.y(), t.z());
    file += Printed("  quaternion_wxyz: [%.9f, %.9f, %.9f, %.9f]\n", q.w(), q.x(), q.y(), q.z());
    file += "  axes: kawara\n";
  }
  return file;
}

core::Expected<survey::BodyAxes> BodyAxesOf(const std::string& folder) {
  const std::string file = folder + "/camera.yaml";
  const auto bytes = survey::ReadBytes(file);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto config = survey::ParseSurveyConfig(
      {reinterpret_cast<const char*>(bytes->data()), bytes->size()}, file);
  if (!config) return tl::unexpected(config.error());
  return config->body_axes;
}

}  // namespace

core::Expected<MountingResult> RunMounting(const MountingOptions& options,
                                           const std::function<void(const std::string&)>& say) {
  const auto survey = survey::OpenSurvey(options.survey);
  if (!survey) return tl::unexpected(survey.error());
  const auto body = BodyAxesOf(options.survey);
  if (!body) return tl::unexpected(body.error());
  auto file = navigate::SafeFile::Create(options.out);
  if (!file) return tl::unexpected(file.error());
  MountingResult result;
  Cameras cameras;
  for (const survey::SurveyCamera& camera : survey->cameras) {
    cameras.push_back(std::make_unique<vision::StereoCamera>(camera.model, camera.mask));
    result.cameras.push_back({camera.name, camera.body_from_camera});
  }
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  bool settled = false;
  for (int pass = 0; pass < kMostPasses && !settled; ++pass) {
    const auto rig = Pass(*survey, cameras, options, result);
    if (!rig) return tl::unexpected(rig.error());
    const Eigen::Matrix3d turn = vision::Exp(rig->mounting_rad);
    for (CameraMounting& camera : result.cameras) {
      camera.body_from_camera.linear() = turn * camera.body_from_camera.linear();
    }
    turned = turn * turned;
    result.turn_rad = vision::Log(turned);
    settled = (rig->mounting_rad.cwiseAbs().array() <
               (kSettledShare * result.turn_sd_rad).array().max(kSettled))
                  .all();
    say(Printed("pass %d: turned by %.3f deg, corners fit to %.2f px", pass + 1,
                rig->mounting_rad.norm() / core::kRadFromDeg, result.residual_px));
  }
  if (auto good = Judge(options, result); !good) return tl::unexpected(good.error());
  if (!settled) {
    say("warning: the mounting still moved in the last pass: its deviations are too good");
  }
  if (auto done = file->Write(FileOf(result, *body)); !done) return tl::unexpected(done.error());
  if (auto done = file->Commit(); !done) return tl::unexpected(done.error());
  return result;
}

}  // namespace kawara::calibrate
