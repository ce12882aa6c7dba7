#include "onboard/survey/picture_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>

namespace kawara::survey {
namespace {

std::int64_t BigEndian(std::span<const std::uint8_t> b, std::size_t at, std::size_t count) {
  std::int64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value * 256 + b[at + i];
  return value;
}

/// From the header. Empty: no PNG.
std::optional<std::int64_t> PngPixels(std::span<const std::uint8_t> b) {
  constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  if (b.size() < 24 || !std::equal(kSignature.begin(), kSignature.end(), b.begin())) return {};
  constexpr std::int64_t kMany = 1'000'000'000;  // no overflow below
  return std::min(BigEndian(b, 16, 4), kMany) * std::min(BigEndian(b, 20, 4), kMany);
}

/// From the frame header (SOF0 to SOF15 but the tables among them). Empty: no JPEG.
std::optional<std::int64_t> JpegPixels(std::span<const std::uint8_t> b) {
  if (b.size() < 4 || b[0] != 0xFF || b[1] != 0xD8) return {};
  for (std::size_t at = 2; at + 9 <= b.size();) {
    if (b[at] != 0xFF) return {};
    const std::uint8_t marker = b[at + 1];
    if (marker == 0xFF) {  // filling
      ++at;
      continue;
    }
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) return BigEndian(b, at + 5, 2) * BigEndian(b, at + 7, 2);
    at += 2 + static_cast<std::size_t>(BigEndian(b, at + 2, 2));
  }
  return {};
}

/// A copy that was cut short: OpenCV would fill up what is missing with grey and say nothing. A
/// JPEG ends with the marker EOI, which cannot be within the scan's data (0xFF is followed by 0
/// there); a PNG with the chunk IEND. Anything may follow.
bool EndsEarly(std::span<const std::uint8_t> b) {
  const bool jpeg = b[0] == 0xFF;
  std::size_t at = 8;
  if (jpeg) {
    // To the first scan: thumbnails lie in segments before it.
    for (at = 2; at + 4 <= b.size() && b[at + 1] != 0xDA;) {
      at += b[at + 1] == 0xFF ? 1 : 2 + static_cast<std::size_t>(BigEndian(b, at + 2, 2));
    }
  }
  constexpr std::array<std::uint8_t, 2> kJpegEnd = {0xFF, 0xD9};
  constexpr std::array<std::uint8_t, 4> kPngEnd = {'I', 'E', 'N', 'D'};
  const auto rest = b.subspan(std::min(at, b.size()));
  const auto found = jpeg ? std::search(rest.begin(), rest.end(), kJpegEnd.begin(), kJpegEnd.end())
                          : std::search(rest.begin(), rest.end(), kPngEnd.begin(), kPngEnd.end());
  return found == rest.end();
}

}  // namespace

core::Expected<Picture> DecodePicture(std::span<const std::uint8_t> bytes) {
  // Not whatever else OpenCV could read: its other decoders are not for strangers' bytes.
  auto pixels = PngPixels(bytes);
  if (!pixels) pixels = JpegPixels(bytes);
  if (!pixels) return core::Fail(core::ErrorCode::kFormat, "neither JPEG nor PNG");
  if (*pixels > kMaxPicturePixels) {
    return core::Fail(
        core::ErrorCode::kFormat,
        "a picture of " + std::to_string(*pixels / 1'000'000) + " megapixels: expected at most 80");
  }
  if (EndsEarly(bytes)) {
    return core::Fail(core::ErrorCode::kFormat,
                      "the picture ends early: copy it again, or take it out of the folder");
  }
  cv::Mat bgr;
  try {
    const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8UC1,
                      const_cast<std::uint8_t*>(bytes.data()));
    bgr = cv::imdecode(raw, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    bgr.release();  // the same answer as to damage
  }
  if (bgr.empty() || bgr.type() != CV_8UC3) {
    return core::Fail(core::ErrorCode::kFormat, "damaged picture");
  }
  Picture picture;
  picture.width_px = bgr.cols;
  picture.height_px = bgr.rows;
  picture.rgb.resize(picture.view().size_bytes());
  std::uint8_t* out = picture.rgb.data();
  for (int v = 0; v < bgr.rows; ++v) {
    const std::uint8_t* in = bgr.ptr<std::uint8_t>(v);
    for (int u = 0; u < bgr.cols; ++u, in += 3, out += 3) {
      out[0] = in[2];
      out[1] = in[1];
      out[2] = in[0];
    }
  }
  return picture;
}

core::Expected<Picture> LoadPicture(const std::filesystem::path& file) {
  const auto bytes = ReadBytes(file);
  if (!bytes) return tl::unexpected(bytes.error());
  auto picture = DecodePicture(*bytes);
  if (!picture) {
    return core::Fail(picture.error().code, file.string() + ": " + picture.error().message);
  }
  return picture;
}

core::Expected<std::vector<std::uint8_t>> ReadBytes(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           std::fclose);
  if (!in) return tl::unexpected(core::ErrnoError(file.string(), errno));
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint8_t> block(std::size_t{1} << 16);
  for (std::size_t n = 0; (n = std::fread(block.data(), 1, block.size(), in.get())) > 0;) {
    bytes.insert(bytes.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(n));
  }
  if (std::ferror(in.get()) != 0) return tl::unexpected(core::ErrnoError(file.string(), errno));
  return bytes;
}

}  // namespace kawara::survey
