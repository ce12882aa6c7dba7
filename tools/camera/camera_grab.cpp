#include <cstdio>
#include <fstream>

#include "tools/camera/camera_commands.hpp"
#include "tools/camera/camera_frames.hpp"
#include "vision/jpeg.hpp"
#include "vision/png.hpp"

namespace kawara::tools {
namespace {

constexpr int kJpegQuality = 95;

vision::ConstImageView ViewOf(const drivers::Frame& frame, std::span<const std::uint8_t> rgb) {
  return {rgb.data(), static_cast<int>(frame.width), static_cast<int>(frame.height)};
}

std::vector<std::uint8_t> RgbFromGrey(std::span<const std::uint8_t> grey) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * grey.size());
  for (const std::uint8_t level : grey) rgb.insert(rgb.end(), 3, level);
  return rgb;
}

core::Expected<std::vector<std::uint8_t>> Encode(const drivers::Frame& frame, bool png) {
  const bool jpeg = frame.format == drivers::PixelFormat::kJpeg;
  if (jpeg && !png) return frame.bytes;  // the camera's own
  vision::JpegDecoder decoder;
  std::vector<std::uint8_t> grey;
  vision::ConstImageView view = ViewOf(frame, frame.bytes);
  if (jpeg) {
    const auto decoded = decoder.Decode(frame.bytes);
    if (!decoded) return tl::unexpected(decoded.error());
    view = *decoded;
  } else if (frame.format == drivers::PixelFormat::kGrey8) {
    grey = RgbFromGrey(frame.bytes);
    view = ViewOf(frame, grey);
  }
  if (png) return vision::EncodePng(view, vision::kPngSmall);
  vision::JpegEncoder encoder;
  const auto bytes = encoder.Encode(view, {.quality = kJpegQuality});
  if (!bytes) return tl::unexpected(bytes.error());
  return std::vector<std::uint8_t>(bytes->begin(), bytes->end());
}

}  // namespace

core::Expected<int> CameraGrab(const CameraOptions& options, const std::string& file, int skip) {
  const bool png = file.ends_with(".png");
  if (!png && !file.ends_with(".jpg") && !file.ends_with(".jpeg")) {
    return core::Fail(core::ErrorCode::kInvalidArgument, file + ": expected NAME.jpg or NAME.png");
  }
  auto config = ConfigOf(options);
  if (!config) return tl::unexpected(config.error());
  core::Counters counters;
  drivers::V4l2Camera camera(std::move(*config), counters);
  drivers::Frame picture;
  const auto taken = ForFrames(camera, core::DurationFromSeconds(options.patience_s),
                               [&](const drivers::Frame& frame) {
                                 if (skip-- > 0) return true;
                                 picture = frame;
                                 return false;
                               });
  if (!taken) return tl::unexpected(taken.error());
  const auto bytes = Encode(picture, png);
  if (!bytes) return tl::unexpected(bytes.error());
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes->data()),
            static_cast<std::streamsize>(bytes->size()));
  out.close();
  if (!out) return core::Fail(core::ErrorCode::kIo, file + ": cannot be written (folder? disk?)");
  std::printf("%s\n%s: frame %u, %ux%u, %zu bytes\n", camera.Description().c_str(), file.c_str(),
              picture.sequence, picture.width, picture.height, bytes->size());
  return 0;
}

}  // namespace kawara::tools
