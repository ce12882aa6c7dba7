#include "onboard/survey/survey.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "onboard/survey/frame_matching.hpp"
#include "onboard/survey/pose_motion.hpp"
#include "vision/camera/resized_camera.hpp"

namespace kawara::survey {
namespace {

namespace fs = std::filesystem;
using core::ErrorCode;
using core::Fail;

/// The model and, where the calibration has one, the mounting.
struct Optics {
  std::shared_ptr<const vision::CameraModel> model;
  vision::OpticalAxis axis = vision::OpticalAxis::kForward;
  std::optional<Eigen::Isometry3d> body_from_camera;
  double time_offset_s = 0.0;
};

core::Expected<std::string> ReadText(const fs::path& file) {
  const auto bytes = ReadBytes(file);
  if (!bytes) return tl::unexpected(bytes.error());
  return std::string(bytes->begin(), bytes->end());
}

core::Expected<Calibration> FindCalibration(const fs::path& folder, const CameraConfig& config) {
  const std::string path = (folder / config.calibration).string();
  const auto text = ReadText(path);
  if (!text) return tl::unexpected(text.error());
  auto all = ParseCalibration(*text, path, config.calibration_as);
  if (!all) return tl::unexpected(all.error());
  const std::string& wanted =
      config.calibration_camera.empty() ? config.name : config.calibration_camera;
  const auto found = std::ranges::find(*all, wanted, &Calibration::name);
  if (found != all->end()) return *found;
  if (all->size() == 1 && config.calibration_camera.empty()) return all->front();
  return Fail(ErrorCode::kFormat, path + ": no camera '" + wanted + "' among its " +
                                      std::to_string(all->size()) +
                                      ": say which by calibration_camera in camera.yaml");
}

/// The keys beside `calibration:`.
void Apply(const CameraConfig& config, vision::CameraChoice& optics) {
  const auto set = [&](vision::LensCommon& common) {
    common.mirrored = config.mirrored;
    common.axis = config.axis;
  };
  set(optics.kb4.common);
  set(optics.ocam.common);
  set(optics.mei.common);
  set(optics.eucm.common);
  set(optics.double_sphere.common);
}

core::Expected<Optics> MakeOptics(const fs::path& folder, const CameraConfig& config) {
  Optics optics;
  vision::CameraChoice choice = config.optics;
  if (!config.calibration.empty()) {
    auto calibration = FindCalibration(folder, config);
    if (!calibration) return tl::unexpected(calibration.error());
    choice = calibration->optics;
    Apply(config, choice);
    if (choice.mei.common.width_px == 0) {  // SetSize sets all models'
      choice.kb4.common.width_px = choice.mei.common.width_px = config.width_px;
      choice.kb4.common.height_px = choice.mei.common.height_px = config.height_px;
      if (config.width_px == 0 || config.height_px == 0) {
        return Fail(ErrorCode::kFormat, (folder / config.calibration).string() +
                                            ": has no picture size: say width_px and height_px of "
                                            "the calibration in camera.yaml");
      }
    }
    if (calibration->has_mounting) {
      const Eigen::Matrix3d R = vision::CameraFromOptical(config.axis).transpose();
      optics.body_from_camera =
          calibration->body_from_optical * Eigen::Isometry3d(Eigen::Quaterniond(R));
    }
    optics.time_offset_s = calibration->time_offset_s;
  }
  auto model = vision::MakeCamera(choice);
  if (!model) {
    return Fail(model.error().code,
                (folder / "camera.yaml").string() + ": " + model.error().message);
  }
  optics.model = *model;
  optics.axis = AxisOf(choice);
  return optics;
}

core::Expected<SurveyCamera> MakeCamera(const fs::path& folder, const CameraConfig& config,
                                        BodyAxes body, const Picture& first,
                                        const fs::path& first_file) {
  auto optics = MakeOptics(folder, config);
  if (!optics) return tl::unexpected(optics.error());
  SurveyCamera camera;
  camera.name = config.name;
  camera.model = optics->model;
  if (first.width_px != camera.model->width_px() || first.height_px != camera.model->height_px()) {
    if (!config.scale_to_picture) {
      return Fail(ErrorCode::kFormat,
                  first_file.string() + " has " + std::to_string(first.width_px) + " x " +
                      std::to_string(first.height_px) + " px, the calibration is for " +
                      std::to_string(camera.model->width_px()) + " x " +
                      std::to_string(camera.model->height_px()) +
                      ": if the pictures were reduced as a whole, say scale_to_picture: true");
    }
    camera.model =
        std::make_shared<vision::ResizedCamera>(camera.model, first.width_px, first.height_px);
  }
  // A mounting in camera.yaml goes before the calibration's; without either, upright and ahead.
  if (config.mounting || !optics->body_from_camera) {
    const auto pose =
        BodyFromCamera(config.mounting.value_or(MountingConfig{}), body, optics->axis);
    if (!pose) {
      return Fail(pose.error().code,
                  (folder / "camera.yaml").string() + ": " + pose.error().message);
    }
    camera.body_from_camera = *pose;
  } else {
    camera.body_from_camera = *optics->body_from_camera;
  }
  camera.line_delay_s = config.line_delay_s;
  camera.readout = config.readout;
  camera.time_offset_s = optics->time_offset_s + config.time_offset_s;
  if (!config.mask.empty()) {
    const fs::path file = folder / config.mask;
    const auto mask = LoadPicture(file);
    if (!mask) return tl::unexpected(mask.error());
    if (mask->width_px != first.width_px || mask->height_px != first.height_px) {
      return Fail(ErrorCode::kFormat, file.string() + ": expected the pictures' size, " +
                                          std::to_string(first.width_px) + " x " +
                                          std::to_string(first.height_px) + " px");
    }
    for (std::size_t i = 0; i < mask->rgb.size(); i += 3) {
      const bool used = mask->rgb[i] != 0 || mask->rgb[i + 1] != 0 || mask->rgb[i + 2] != 0;
      camera.mask.push_back(used ? 255 : 0);
    }
  }
  return camera;
}

core::Expected<PoseTable> ReadPoses(const fs::path& folder, BodyAxes body,
                                    const std::optional<core::Geodetic>& origin) {
  for (const char* name : {"poses.csv", "poses.txt", "poses.tum"}) {
    std::error_code error;
    const std::string path = (folder / name).string();
    if (!fs::exists(path, error)) continue;
    const auto text = ReadText(path);
    if (!text) return tl::unexpected(text.error());
    return ParsePoses(*text, path, body, origin);
  }
  return Fail(ErrorCode::kNotFound,
              (folder / "poses.csv").string() + ": no such file (nor poses.txt, poses.tum)");
}

fs::path WhereFramesAre(const fs::path& folder, const CameraConfig& config, bool several) {
  if (!config.frames.empty()) return folder / config.frames;
  return several ? folder / "frames" / config.name : folder / "frames";
}

}  // namespace

core::Expected<Survey> OpenSurvey(const fs::path& folder,
                                  const std::optional<core::Geodetic>& origin) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Fail(ErrorCode::kNotFound, folder.string() + ": no such folder");
  }
  const std::string camera_file = (folder / "camera.yaml").string();
  const auto text = ReadText(camera_file);
  if (!text) return tl::unexpected(text.error());
  const auto config = ParseSurveyConfig(*text, camera_file);
  if (!config) return tl::unexpected(config.error());
  auto poses = ReadPoses(folder, config->body_axes, origin);
  if (!poses) return tl::unexpected(poses.error());

  Survey survey;
  survey.origin = poses->origin;
  std::vector<std::vector<fs::path>> pictures;
  std::vector<std::vector<int>> picture_of;  // by camera, by row of poses
  for (const CameraConfig& one : config->cameras) {
    auto files = ListPictures(WhereFramesAre(folder, one, config->cameras.size() > 1));
    if (!files) return tl::unexpected(files.error());
    const auto first = LoadPicture(files->front());
    if (!first) return tl::unexpected(first.error());
    auto camera = MakeCamera(folder, one, config->body_axes, *first, files->front());
    if (!camera) return tl::unexpected(camera.error());
    auto match = MatchPictures(poses->rows, one.name, *files);
    if (!match) return tl::unexpected(match.error());
    std::set<int> posed(match->begin(), match->end());
    posed.erase(-1);
    survey.pictures_without_pose += static_cast<int>(files->size() - posed.size());
    survey.cameras.push_back(std::move(*camera));
    pictures.push_back(std::move(*files));
    picture_of.push_back(std::move(*match));
  }
  for (std::size_t r = 0; r < poses->rows.size(); ++r) {
    bool used = false;
    for (std::size_t c = 0; c < pictures.size(); ++c) {
      if (picture_of[c][r] < 0) continue;
      used = true;
      const fs::path& file = pictures[c][static_cast<std::size_t>(picture_of[c][r])];
      SurveyFrame frame{static_cast<int>(c), file, file.stem().string(), poses->rows[r]};
      frame.pose.map_from_body = PoseLater(poses->rows, r, survey.cameras[c].time_offset_s);
      survey.frames.push_back(std::move(frame));
    }
    survey.poses_without_picture += used ? 0 : 1;
  }
  if (survey.frames.empty()) {
    return Fail(ErrorCode::kFormat,
                folder.string() +
                    ": no pose fits a picture: the names in column 'frame' or 'file' "
                    "of the poses are not those of the pictures");
  }
  return survey;
}

std::string FullNameOf(const Survey& survey, const SurveyFrame& frame) {
  const std::string& camera = survey.cameras[static_cast<std::size_t>(frame.camera)].name;
  return survey.cameras.size() > 1 && !camera.empty() ? camera + "/" + frame.name : frame.name;
}

core::Expected<Picture> LoadFrame(const Survey& survey, const SurveyFrame& frame) {
  auto picture = LoadPicture(frame.file);
  if (!picture) return picture;
  const vision::CameraModel& model = *survey.cameras[static_cast<std::size_t>(frame.camera)].model;
  if (picture->width_px != model.width_px() || picture->height_px != model.height_px()) {
    return Fail(ErrorCode::kFormat,
                frame.file.string() + " has " + std::to_string(picture->width_px) + " x " +
                    std::to_string(picture->height_px) + " px, the camera's pictures " +
                    std::to_string(model.width_px()) + " x " + std::to_string(model.height_px()));
  }
  return picture;
}

}  // namespace kawara::survey
