#include "sim/world/rendered_pictures.hpp"

#include <cstdlib>
#include <utility>

#include "vision/camera/equirectangular_camera.hpp"
#include "vision/jpeg.hpp"
#include "vision/panorama_metadata.hpp"

namespace kawara::sim {

RenderedPictures::RenderedPictures(const SiteWorld& world,
                                   std::shared_ptr<const vision::CameraModel> camera,
                                   const RenderedCameraOptions& options)
    : world_(world),
      options_(options),
      renderer_(world.lit(), std::move(camera), options.settings,
                options.robot_in_view ? SurveyRobotBody() : RobotBody{}) {}

RenderedFrame RenderedPictures::Render(core::GpsTime t) const {
  RenderRequest request;
  request.enu_from_camera = [this, t](double seconds) {
    return world_.EnuFromCamera(t + core::DurationFromSeconds(seconds));
  };
  request.time_s = world_.MissionSeconds(t);
  request.exposure_s = options_.exposure_s;
  request.readout_s = options_.readout_s;
  // The same instant gives the same noise, so that a survey and a live run agree.
  request.noise_seed = options_.seed + static_cast<std::uint64_t>(t.ns());
  return renderer_.Render(request);
}

core::Expected<Picture> RenderedPictures::Draw(core::GpsTime exposure) const {
  const RenderedFrame frame = Render(exposure + core::DurationFromSeconds(options_.exposure_s / 2));
  vision::JpegEncoder encoder;
  const auto jpeg = encoder.Encode(frame.view(), {.quality = options_.jpeg_quality});
  if (!jpeg) return tl::unexpected(jpeg.error());
  Picture picture;
  picture.width = static_cast<std::uint32_t>(frame.width_px);
  picture.height = static_cast<std::uint32_t>(frame.height_px);
  const auto* sphere = dynamic_cast<const vision::EquirectangularCamera*>(&renderer_.camera());
  if (sphere == nullptr) {
    picture.jpeg.assign(jpeg->begin(), jpeg->end());
  } else {  // a stitching camera says which part of the sphere it shows
    vision::PanoramaMetadata metadata;
    metadata.geometry = sphere->geometry();
    metadata.software = "kawara-sim";
    auto done = vision::InsertPanoramaMetadata(*jpeg, metadata, &picture.jpeg);
    if (!done) return tl::unexpected(done.error());
  }
  picture.exposed = exposure;
  return picture;
}

core::Expected<void> RenderedPictures::RenderAhead(
    core::GpsTime begin, core::GpsTime end, core::Duration period,
    const std::function<void(std::size_t, std::size_t)>& progress, const std::atomic<bool>& stop) {
  const std::int64_t first = (begin.ns() + period.count() - 1) / period.count();
  const std::int64_t last = end.ns() / period.count();
  for (std::int64_t i = first; i <= last && !stop.load(); ++i) {
    const core::GpsTime exposure = core::GpsTime::FromNs(i * period.count());
    auto picture = Draw(exposure);
    if (!picture) return tl::unexpected(picture.error());
    drawn_.insert_or_assign(exposure, std::move(*picture));
    progress(drawn_.size(), static_cast<std::size_t>(last - first + 1));
  }
  ahead_ = drawn_.size();
  return {};
}

const Picture* RenderedPictures::DrawnNear(core::GpsTime exposure) const {
  const auto off = [exposure](core::GpsTime t) { return std::abs((t - exposure).count()); };
  const auto end = drawn_.upper_bound(exposure + kShutterTolerance);
  const Picture* nearest = nullptr;
  for (auto it = drawn_.lower_bound(exposure - kShutterTolerance); it != end; ++it) {
    if (nearest == nullptr || off(it->first) < off(nearest->exposed)) nearest = &it->second;
  }
  return nearest;
}

void RenderedPictures::Prepare(core::GpsTime expected) {
  if (DrawnNear(expected) != nullptr) return;
  const core::MonoTime begin = core::MonoNow();
  if (auto picture = Draw(expected)) drawn_.insert_or_assign(expected, std::move(*picture));
  takes_ = core::MonoNow() - begin;
}

core::Expected<Picture> RenderedPictures::Expose(const Caption& caption) {
  if (const Picture* drawn = DrawnNear(caption.exposure)) {
    Picture picture = *drawn;
    if (drawn_.size() > ahead_) drawn_.erase(picture.exposed);
    return picture;
  }
  ++rendered_late_;
  return Draw(caption.exposure);
}

}  // namespace kawara::sim
