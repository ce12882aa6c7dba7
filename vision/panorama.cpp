#include "vision/panorama.hpp"

#include <utility>

#include "vision/camera/half_scale_camera.hpp"

namespace kawara::vision {
namespace {

constexpr int kMaxWidthPx = 32768;
constexpr int kMaxSamplesPerAxis = 4;

}  // namespace

core::Expected<PanoramaUnwrapper> PanoramaUnwrapper::Create(
    std::shared_ptr<const CameraModel> camera, const PanoramaConfig& config, RemapFormat format) {
  using core::ErrorCode;
  if (config.width_px < 64 || config.width_px > kMaxWidthPx || config.width_px % 2 != 0) {
    return core::Fail(ErrorCode::kInvalidArgument,
                      "panorama: width_px = " + std::to_string(config.width_px) +
                          ": expected an even number, 64.." + std::to_string(kMaxWidthPx));
  }
  ElevationRange elevations = camera->Elevations();
  if (config.elevation_top_deg != 0.0 || config.elevation_bottom_deg != 0.0) {
    elevations = {config.elevation_bottom_deg * core::kRadFromDeg,
                  config.elevation_top_deg * core::kRadFromDeg};
  }
  if (!(elevations.bottom_rad < elevations.top_rad) || elevations.top_rad > core::kPi / 2 + 1e-9 ||
      elevations.bottom_rad < -core::kPi / 2 - 1e-9) {
    return core::Fail(
        ErrorCode::kInvalidArgument,
        "panorama: elevation_bottom_deg = " +
            std::to_string(elevations.bottom_rad * core::kDegFromRad) +
            ", elevation_top_deg = " + std::to_string(elevations.top_rad * core::kDegFromRad) +
            ": expected -90 <= bottom < top <= 90");
  }
  auto target = EquirectangularCamera::Create(PanoramaGeometry::Band(config.width_px, elevations));
  if (!target) return tl::unexpected(target.error());
  PanoramaUnwrapper unwrapper(std::move(camera), config, format, *target);
  if (auto built = unwrapper.BuildTable(); !built) return tl::unexpected(built.error());
  return unwrapper;
}

PanoramaUnwrapper::PanoramaUnwrapper(std::shared_ptr<const CameraModel> camera,
                                     const PanoramaConfig& config, RemapFormat format,
                                     EquirectangularCamera target)
    : camera_(std::move(camera)),
      config_(config),
      format_(format),
      target_(std::move(target)),
      R_body_mount_(core::RotationNedFromBody({config.mount_roll_deg * core::kRadFromDeg,
                                               config.mount_pitch_deg * core::kRadFromDeg,
                                               config.mount_yaw_deg * core::kRadFromDeg})),
      R_body_picture_(Eigen::Matrix3d::Identity()) {}

core::Expected<void> PanoramaUnwrapper::BuildTable() {
  const Eigen::Matrix3d R_mount_picture = R_body_mount_.transpose() * R_body_picture_;
  const Eigen::Matrix3d R_camera_target =
      BodyFromCamera().transpose() * R_mount_picture * BodyFromCamera();
  auto built = table_.Rebuild(*camera_, target_, R_camera_target, kMaxSamplesPerAxis, format_);
  if (!built || format_ != RemapFormat::kPlane) return built;
  return chroma_table_.Rebuild(HalfScaleCamera(*camera_), HalfScaleCamera(target_), R_camera_target,
                               kMaxSamplesPerAxis, format_);
}

core::Expected<void> PanoramaUnwrapper::SetAttitude(const core::Attitude& body) {
  if (!config_.level && !config_.north_up) return {};
  // The picture's own attitude: what is not taken out stays as the body has it.
  const core::Attitude picture{config_.level ? 0.0 : body.roll_rad,
                               config_.level ? 0.0 : body.pitch_rad,
                               config_.north_up ? 0.0 : body.yaw_rad};
  R_body_picture_ =
      core::RotationNedFromBody(body).transpose() * core::RotationNedFromBody(picture);
  return BuildTable();
}

core::Attitude PanoramaUnwrapper::PictureAttitude(const core::Attitude& body) const {
  return core::AttitudeFromRotation(core::RotationNedFromBody(body) * R_body_picture_);
}

void PanoramaUnwrapper::Unwrap(const ConstImageView& picture, const ImageView& panorama) const {
  table_.Apply(picture, panorama, config_.threads);
}

void PanoramaUnwrapper::UnwrapYuv420(const ConstYuv420View& picture,
                                     const Yuv420View& panorama) const {
  table_.Apply(picture.y, panorama.y, kBlackLuma, config_.threads);
  chroma_table_.Apply(picture.cb, panorama.cb, kBlackChroma, config_.threads);
  chroma_table_.Apply(picture.cr, panorama.cr, kBlackChroma, config_.threads);
}

}  // namespace kawara::vision
