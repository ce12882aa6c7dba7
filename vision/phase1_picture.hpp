#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/config/constraints.hpp"
#include "core/expected.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/panorama.hpp"
#include "vision/source_frame.hpp"

namespace kawara::vision {

/// How the 1st update's pictures are made. Lines of the onboard configuration.
struct Phase1PictureConfig {
  /// "doughnut": a mirror camera's ring, unwrapped. "equirectangular": a stitched 360 camera,
  /// passed through.
  std::string camera = "doughnut";
  DoughnutParameters doughnut;  ///< used with camera = doughnut
  PanoramaConfig
      panorama;  ///< used with camera = doughnut; mount also says how a 360 camera stands
  int quality = 85;
  bool progressive = false;
  /// Pass-through: 0 sends the camera's own bytes; otherwise wider pictures are reduced to this and
  /// re-encoded.
  int max_width_px = 0;
  int preview_width_px = 512;
  int preview_quality = 50;

  template <class V>
  void Visit(V& v) {
    using core::config::OneOf;
    using core::config::Optional;
    using core::config::Range;
    v("camera", camera, OneOf{"doughnut", "equirectangular"});
    v("doughnut", doughnut, Optional{});
    v("panorama", panorama, Optional{});
    v("quality", quality, Range{1, 100});
    v("progressive", progressive, Optional{});
    v("max_width_px", max_width_px, Range{0, 65500}, Optional{});
    v("preview_width_px", preview_width_px, Range{64, 8192}, Optional{});
    v("preview_quality", preview_quality, Range{1, 100}, Optional{});
  }
};

/// A picture ready but for its metadata (InsertPanoramaMetadata, once the pose is known).
struct EncodedPicture {
  /// Lives until the next call of the same method, and in pass-through not longer than the frame's
  /// bytes.
  std::span<const std::uint8_t> jpeg;
  PanoramaGeometry geometry;
  /// Not empty: take the camera's EXIF and XMP from here (a re-encoded pass-through picture).
  std::span<const std::uint8_t> original;
};

/// The picture job of the 1st update: for one frame first Preview, then Full. Needs no pose (except
/// levelling), so it can start while the pose is still being computed. Pure function of
/// configuration and frame (and attitude): the same bytes in, the same bytes out. Buffers are
/// allocated by the first frame and kept. One thread at a time.
///
/// A doughnut stays in the YCbCr 4:2:0 that cameras write and panoramas are written in: its planes
/// are decoded once, unwrapped each with its own table, and encoded. Other JPEGs and RGB frames are
/// brought to that first.
class Phase1Picture {
 public:
  /// kInvalidArgument names the key that is wrong.
  static core::Expected<Phase1Picture> Create(const Phase1PictureConfig& config);
  ~Phase1Picture();
  Phase1Picture(Phase1Picture&&) noexcept;
  Phase1Picture& operator=(Phase1Picture&&) noexcept;

  /// Small picture. kFormat: the frame is damaged or not of the camera's size.
  core::Expected<EncodedPicture> Preview(const SourceFrame& frame);
  /// Full picture. Errors as above.
  core::Expected<EncodedPicture> Full(const SourceFrame& frame);

  /// Attitude for `panorama.level` and `north_up`; call before Preview and Full of a frame.
  /// Otherwise no effect.
  core::Expected<void> SetAttitude(const core::Attitude& body);
  /// The attitude to write into the metadata of pictures of a body that stands as `body`.
  core::Attitude PictureAttitude(const core::Attitude& body) const;

 private:
  struct Impl;
  explicit Phase1Picture(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::vision
