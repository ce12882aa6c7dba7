#pragma once
#include <atomic>
#include <functional>
#include <map>
#include <memory>

#include "sim/camera/picture_source.hpp"
#include "sim/render/renderer.hpp"
#include "sim/world/site_world.hpp"

namespace kawara::sim {

/// A simulated camera's settings: optics are its CameraModel, the rest is here.
struct RenderedCameraOptions {
  CameraSettings settings;
  double exposure_s = 0.004;
  double readout_s = 0.0;  ///< rolling shutter: first row to last; 0: global
  bool robot_in_view = true;
  int jpeg_quality = 90;
  std::uint64_t seed = 1;  ///< of the noise
};

/// What the camera on the vehicle sees of a site. Frames are rendered when they are expected, or
/// all beforehand, since they take longer than a camera's readout; an exposure that comes at
/// another time is rendered then, and is delivered so much later. A frame says which exposure it
/// really shows. One thread (rendering uses all of oneTBB's).
class RenderedPictures final : public PictureSource {
 public:
  /// `world` must outlive this.
  RenderedPictures(const SiteWorld& world, std::shared_ptr<const vision::CameraModel> camera,
                   const RenderedCameraOptions& options);

  /// Draws the exposures at whole multiples of `period` of GPS time from begin to end, before they
  /// are wanted: then live pictures cost this machine nothing. `progress` is told how many are
  /// done, of how many. Ends early when `stop` is set. Errors: the encoder's.
  core::Expected<void> RenderAhead(core::GpsTime begin, core::GpsTime end, core::Duration period,
                                   const std::function<void(std::size_t, std::size_t)>& progress,
                                   const std::atomic<bool>& stop);

  void Prepare(core::GpsTime expected) override;
  core::Expected<Picture> Expose(const Caption& caption) override;

  /// The picture and its truth at mid-exposure `t`.
  RenderedFrame Render(core::GpsTime t) const;
  /// How long the last picture took that Prepare() drew.
  core::Duration PrepareTakes() const { return takes_; }
  std::uint64_t made_late() const override { return rendered_late_; }

  /// The shutter may open so much off its trigger: an exposure drawn for an instant that near is
  /// taken.
  static constexpr core::Duration kShutterTolerance = core::Milliseconds(20);

 private:
  core::Expected<Picture> Draw(core::GpsTime exposure) const;
  /// Null: none within the tolerance.
  const Picture* DrawnNear(core::GpsTime exposure) const;

  const SiteWorld& world_;
  RenderedCameraOptions options_;
  Renderer renderer_;
  std::map<core::GpsTime, Picture> drawn_;  ///< by start of exposure
  std::size_t ahead_ = 0;                   ///< how many of them RenderAhead() made: these stay
  std::uint64_t rendered_late_ = 0;
  core::Duration takes_{};  ///< the last picture drawn in Prepare()
};

}  // namespace kawara::sim
