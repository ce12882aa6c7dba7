#include "vision/phase1_picture.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "vision/camera/equirectangular_camera.hpp"
#include "vision/panorama_metadata.hpp"
#include "vision/remap_table.hpp"

namespace kawara::vision {
namespace {

using core::ErrorCode;
using core::Fail;

constexpr int kPreviewMaxSamplesPerAxis = 8;  // an uncompressed frame arrives in full size

struct PixelBuffer {
  std::vector<std::uint8_t> bytes;
  ImageView View(int width_px, int height_px) {
    ImageView view{nullptr, width_px, height_px};
    if (bytes.size() < view.size_bytes()) bytes.resize(view.size_bytes());
    view.data = bytes.data();
    return view;
  }
};

// What a stitched picture shows: as its own GPano says; without, the full circle, centred on the
// horizon.
PanoramaGeometry PassThroughGeometry(std::span<const std::uint8_t> jpeg, int width_px,
                                     int height_px) {
  if (!jpeg.empty()) {
    const auto metadata = ReadPanoramaMetadata(jpeg);
    if (metadata && metadata->geometry.width_px == width_px &&
        metadata->geometry.height_px == height_px &&
        EquirectangularCamera::Create(metadata->geometry)) {
      return metadata->geometry;
    }
  }
  PanoramaGeometry geometry = PanoramaGeometry::Full(width_px, height_px);
  if (height_px < width_px / 2) {
    geometry.full_height_px = width_px / 2;
    geometry.top_px = (geometry.full_height_px - height_px) / 2;
  }
  return geometry;
}

}  // namespace

struct Phase1Picture::Impl {
  explicit Impl(const Phase1PictureConfig& c) : config(c) {}

  Phase1PictureConfig config;
  bool pass_through = false;
  Eigen::Matrix3d R_body_mount = Eigen::Matrix3d::Identity();

  JpegEncoder preview_encoder, full_encoder;  // each keeps its last picture

  // Doughnut.
  FramePlanes frames;
  int preview_reduction = 1;  // the preview is unwrapped from planes reduced by this
  std::optional<PanoramaUnwrapper> full_unwrapper, preview_unwrapper;
  Yuv420Buffer reduced_ring, panorama;

  // Pass-through: tables for the two reductions, made when a size is seen first.
  JpegDecoder decoder;
  RemapTable preview_table, full_table;
  PixelBuffer reduced;

  core::Expected<void> SetUp();
  core::Expected<void> SetUpDoughnut();
  core::Expected<ConstYuv420View> Ring(const SourceFrame& frame);
  core::Expected<EncodedPicture> Unwrapped(const SourceFrame& frame, bool preview);
  core::Expected<EncodedPicture> PassedThrough(const SourceFrame& frame, bool preview);
  core::Expected<ConstImageView> Reduce(const ConstImageView& picture, int width_px, bool preview);
};

core::Expected<void> Phase1Picture::Impl::SetUp() {
  const auto wrong = [](const std::string& what) {
    return Fail(ErrorCode::kInvalidArgument, what);
  };
  if (config.camera != "doughnut" && config.camera != "equirectangular") {
    return wrong("camera = " + config.camera + ": expected doughnut or equirectangular");
  }
  for (const auto& [key, quality] : {std::pair{"quality", config.quality},
                                     std::pair{"preview_quality", config.preview_quality}}) {
    if (quality < 1 || quality > 100)
      return wrong(key + (" = " + std::to_string(quality)) + ": expected 1..100");
  }
  if (config.preview_width_px < 64 || config.preview_width_px > 8192 ||
      config.preview_width_px % 2 != 0) {
    return wrong("preview_width_px = " + std::to_string(config.preview_width_px) +
                 ": expected an even number, 64..8192");
  }
  if (config.max_width_px != 0 && (config.max_width_px < 64 || config.max_width_px > 65500)) {
    return wrong("max_width_px = " + std::to_string(config.max_width_px) +
                 ": expected 0 or 64..65500");
  }
  pass_through = config.camera == "equirectangular";
  R_body_mount = core::RotationNedFromBody({config.panorama.mount_roll_deg * core::kRadFromDeg,
                                            config.panorama.mount_pitch_deg * core::kRadFromDeg,
                                            config.panorama.mount_yaw_deg * core::kRadFromDeg});
  if (pass_through) {
    if (config.panorama.level || config.panorama.north_up) {
      return wrong(
          "panorama.level and panorama.north_up need camera = doughnut: a stitched picture is "
          "passed "
          "through, and viewers turn it by its GPano tags");
    }
    return {};
  }
  return SetUpDoughnut();
}

core::Expected<void> Phase1Picture::Impl::SetUpDoughnut() {
  const DoughnutParameters& d = config.doughnut;
  const auto camera = DoughnutCamera::Create(d);
  if (!camera) return tl::unexpected(camera.error());
  // The ring's pixels per turn of elevation, against the preview's width: no larger than it needs.
  const double px_per_turn =
      360.0 * (d.l_out_px - d.l_in_px) / std::abs(d.phi_top_deg - d.phi_bottom_deg);
  while (preview_reduction < 8 && px_per_turn / (2 * preview_reduction) >= config.preview_width_px)
    preview_reduction *= 2;
  const auto small_camera = DoughnutCamera::Create(d.Scaled(8 / preview_reduction));
  if (!small_camera) return tl::unexpected(small_camera.error());

  auto full = PanoramaUnwrapper::Create(std::make_shared<DoughnutCamera>(*camera), config.panorama,
                                        RemapFormat::kPlane);
  if (!full) return tl::unexpected(full.error());
  full_unwrapper = std::move(*full);
  PanoramaConfig small = config.panorama;
  small.width_px = config.preview_width_px;
  auto preview = PanoramaUnwrapper::Create(std::make_shared<DoughnutCamera>(*small_camera), small,
                                           RemapFormat::kPlane);
  if (!preview) return tl::unexpected(preview.error());
  preview_unwrapper = std::move(*preview);
  return {};
}

core::Expected<ConstYuv420View> Phase1Picture::Impl::Ring(const SourceFrame& frame) {
  auto ring = frames.Of(frame);
  if (ring && (ring->width_px() != config.doughnut.width_px ||
               ring->height_px() != config.doughnut.height_px)) {
    return Fail(ErrorCode::kFormat,
                "camera frame: " + SizeText(ring->width_px(), ring->height_px()) +
                    ", but doughnut.width_px, height_px say " +
                    SizeText(config.doughnut.width_px, config.doughnut.height_px) +
                    ": set the camera's mode or calibrate for this one");
  }
  return ring;
}

core::Expected<EncodedPicture> Phase1Picture::Impl::Unwrapped(const SourceFrame& frame,
                                                              bool preview) {
  auto ring = Ring(frame);
  if (!ring) return tl::unexpected(ring.error());
  if (preview && preview_reduction > 1) {
    const Yuv420View small =
        reduced_ring.View((ring->width_px() + preview_reduction - 1) / preview_reduction,
                          (ring->height_px() + preview_reduction - 1) / preview_reduction);
    ReduceYuv420(*ring, preview_reduction, small);
    ring = small;
  }
  const PanoramaUnwrapper& unwrapper = preview ? *preview_unwrapper : *full_unwrapper;
  const PanoramaGeometry& geometry = unwrapper.geometry();
  const Yuv420View target = panorama.View(geometry.width_px, geometry.height_px);
  unwrapper.UnwrapYuv420(*ring, target);
  auto jpeg = preview ? preview_encoder.EncodeYuv420(target, {.quality = config.preview_quality})
                      : full_encoder.EncodeYuv420(target, {config.quality, config.progressive});
  if (!jpeg) return tl::unexpected(jpeg.error());
  return EncodedPicture{*jpeg, geometry, {}};
}

// To `width_px` if it is wider; the table depends on the two sizes alone.
core::Expected<ConstImageView> Phase1Picture::Impl::Reduce(const ConstImageView& picture,
                                                           int width_px, bool preview) {
  if (picture.width_px <= width_px) return picture;
  RemapTable& table = preview ? preview_table : full_table;
  const int height_px =
      std::max(1, static_cast<int>(std::lround(static_cast<double>(picture.height_px) * width_px /
                                               picture.width_px)));
  if (table.source_width_px() != picture.width_px ||
      table.source_height_px() != picture.height_px || table.target_width_px() != width_px) {
    const auto from =
        EquirectangularCamera::Create(PanoramaGeometry::Full(picture.width_px, picture.height_px));
    const auto to = EquirectangularCamera::Create(PanoramaGeometry::Full(width_px, height_px));
    if (!from || !to) return Fail(ErrorCode::kFormat, "camera frame: no such picture size");
    auto built = table.Rebuild(*from, *to, Eigen::Matrix3d::Identity(), kPreviewMaxSamplesPerAxis);
    if (!built) return tl::unexpected(built.error());
  }
  const ImageView target = reduced.View(width_px, height_px);
  table.Apply(picture, target, config.panorama.threads);
  return target;
}

core::Expected<EncodedPicture> Phase1Picture::Impl::PassedThrough(const SourceFrame& frame,
                                                                  bool preview) {
  const bool is_jpeg = frame.format == SourceFrame::Format::kJpeg;
  int width_px = frame.width_px, height_px = frame.height_px;
  if (is_jpeg) {
    const auto info = decoder.ReadInfo(frame.bytes);
    if (!info) return tl::unexpected(info.error());
    width_px = info->width_px;
    height_px = info->height_px;
  }
  const auto jpeg_bytes = is_jpeg ? frame.bytes : std::span<const std::uint8_t>{};
  const PanoramaGeometry geometry = PassThroughGeometry(jpeg_bytes, width_px, height_px);
  const int limit_px = preview ? config.preview_width_px : config.max_width_px;
  if (is_jpeg && !preview && (limit_px == 0 || width_px <= limit_px)) {
    return EncodedPicture{frame.bytes, geometry, {}};
  }
  const int wanted_px = limit_px == 0 ? width_px : std::min(limit_px, width_px);
  auto picture =
      is_jpeg ? decoder.Decode(frame.bytes, {.scale_eighths = ScaleEighthsFor(width_px, wanted_px)})
              : RgbPixels(frame);
  if (!picture) return tl::unexpected(picture.error());
  picture = Reduce(*picture, wanted_px, preview);
  if (!picture) return tl::unexpected(picture.error());
  auto jpeg = preview ? preview_encoder.Encode(*picture, {.quality = config.preview_quality})
                      : full_encoder.Encode(*picture, {config.quality, config.progressive});
  if (!jpeg) return tl::unexpected(jpeg.error());
  PanoramaGeometry made = geometry.Resized(picture->width_px);
  made.height_px = picture->height_px;
  made.full_height_px = std::max(made.full_height_px, made.top_px + made.height_px);
  // A preview does without the camera's thumbnail and maker note: they can outweigh it.
  return EncodedPicture{*jpeg, made, preview ? std::span<const std::uint8_t>{} : jpeg_bytes};
}

core::Expected<Phase1Picture> Phase1Picture::Create(const Phase1PictureConfig& config) {
  auto impl = std::make_unique<Impl>(config);
  if (auto ready = impl->SetUp(); !ready) return tl::unexpected(ready.error());
  return Phase1Picture(std::move(impl));
}

Phase1Picture::Phase1Picture(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Phase1Picture::~Phase1Picture() = default;
Phase1Picture::Phase1Picture(Phase1Picture&&) noexcept = default;
Phase1Picture& Phase1Picture::operator=(Phase1Picture&&) noexcept = default;

core::Expected<EncodedPicture> Phase1Picture::Preview(const SourceFrame& frame) {
  return impl_->pass_through ? impl_->PassedThrough(frame, true) : impl_->Unwrapped(frame, true);
}

core::Expected<EncodedPicture> Phase1Picture::Full(const SourceFrame& frame) {
  return impl_->pass_through ? impl_->PassedThrough(frame, false) : impl_->Unwrapped(frame, false);
}

core::Expected<void> Phase1Picture::SetAttitude(const core::Attitude& body) {
  if (impl_->pass_through) return {};
  if (auto turned = impl_->full_unwrapper->SetAttitude(body); !turned) return turned;
  return impl_->preview_unwrapper->SetAttitude(body);
}

core::Attitude Phase1Picture::PictureAttitude(const core::Attitude& body) const {
  if (!impl_->pass_through) return impl_->full_unwrapper->PictureAttitude(body);
  return core::AttitudeFromRotation(core::RotationNedFromBody(body) * impl_->R_body_mount);
}

}  // namespace kawara::vision
