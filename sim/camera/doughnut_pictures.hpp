#pragma once
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/camera/picture_source.hpp"
#include "sim/motion/motion_track.hpp"
#include "vision/camera/doughnut_camera.hpp"

namespace kawara::sim {

/// What the paper's omnidirectional camera would see in a surrounding given by one stitched 360
/// degree picture: the picture's centre column is taken as NORTH, the surrounding stands still
/// while the vehicle turns under it. (There is no parallax: the surrounding is infinitely far.
/// Rendering a world of its own is another source's work.) Every picture carries its caption at the
/// foot of the forward view, upright in the unwrapped panorama. One thread.
class DoughnutPictures {
 public:
  /// Reads the panorama (equirectangular, full sphere, 2:1). Errors: kNotFound, kFormat,
  /// kInvalidArgument.
  static core::Expected<DoughnutPictures> Open(const std::filesystem::path& panorama,
                                               const vision::DoughnutParameters& geometry,
                                               int jpeg_quality);
  /// Work that can be done before the trigger: the vehicle will probably stand at this yaw.
  void Prepare(double yaw_rad);
  /// The picture of an exposure at this yaw (true heading); quick after a good Prepare().
  core::Expected<Picture> Expose(double yaw_rad, const Caption& caption);

  /// The picture of the last Expose() before compression, BGR.
  const cv::Mat& image() const { return image_; }
  /// Exposures that found nothing prepared and had to render first.
  std::uint64_t rendered_late() const { return rendered_late_; }

 private:
  struct CaptionPixel {
    cv::Point at;      ///< in the picture
    cv::Point2f from;  ///< in the caption, as fractions of its width and height
  };
  DoughnutPictures(const vision::DoughnutCamera& camera, const cv::Mat& panorama, int jpeg_quality);
  void Render(double yaw_rad);
  void PutCaption(const Caption& caption);

  int panorama_width_px_;
  int jpeg_quality_;
  cv::Mat wide_;            ///< the panorama twice side by side, so that a turn is only an offset
  cv::Mat base_u_, map_v_;  ///< where each pixel looks at yaw zero, in `wide_`
  cv::Mat map_u_;
  cv::Mat image_;
  std::vector<CaptionPixel> caption_pixels_;
  double rendered_yaw_rad_;
  std::uint64_t rendered_late_ = 0;
};

/// DoughnutPictures of a vehicle that turns as `track` says.
class TurningPictures final : public PictureSource {
 public:
  /// `track` must outlive this.
  TurningPictures(DoughnutPictures pictures, const MotionTrack& track)
      : pictures_(std::move(pictures)), track_(track) {}
  void Prepare(core::GpsTime expected) override { pictures_.Prepare(track_.YawAt(expected)); }
  core::Expected<Picture> Expose(const Caption& caption) override {
    return pictures_.Expose(track_.YawAt(caption.exposure), caption);
  }

 private:
  DoughnutPictures pictures_;
  const MotionTrack& track_;
};

}  // namespace kawara::sim
