#include "onboard/survey/picture_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>

#include "vision/jpeg.hpp"

namespace kawara::survey {
namespace {

bool IsPng(std::span<const std::uint8_t> b) {
  constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  return b.size() >= kSignature.size() &&
         std::equal(kSignature.begin(), kSignature.end(), b.begin());
}

bool IsJpeg(std::span<const std::uint8_t> b) {
  return b.size() >= 4 && b[0] == 0xFF && b[1] == 0xD8;
}

/// A copy of a JPEG that was cut short. It ends with the marker EOI, which cannot be within the
/// scan's data (0xFF is followed by 0 there). Anything may follow.
bool EndsEarly(std::span<const std::uint8_t> b) {
  // To the first scan: thumbnails lie in segments before it.
  std::size_t at = 2;
  while (at + 4 <= b.size() && b[at + 1] != 0xDA) {
    const std::size_t segment = std::size_t{b[at + 2]} * 256 + b[at + 3];
    at += b[at + 1] == 0xFF ? 1 : 2 + segment;  // or filling
  }
  constexpr std::array<std::uint8_t, 2> kEnd = {0xFF, 0xD9};
  const auto rest = b.subspan(std::min(at, b.size()));
  return std::search(rest.begin(), rest.end(), kEnd.begin(), kEnd.end()) == rest.end();
}

core::Expected<Picture> DecodeJpeg(std::span<const std::uint8_t> bytes) {
  if (EndsEarly(bytes)) {
    return core::Fail(core::ErrorCode::kFormat,
                      "the picture ends early: copy it again, or take it out of the folder");
  }
  // Cameras write odd bytes between markers, which count as damage, and nothing is wrong with the
  // picture.
  vision::JpegDecoder decoder;
  const auto rgb = decoder.Decode(bytes, {.accept_damage = true, .max_pixels = kMaxPicturePixels});
  if (!rgb) return tl::unexpected(rgb.error());
  Picture picture{{}, rgb->width_px, rgb->height_px};
  picture.rgb.assign(rgb->data, rgb->data + rgb->size_bytes());
  return picture;
}

}  // namespace

core::Expected<Picture> DecodePicture(std::span<const std::uint8_t> bytes) {
  if (IsPng(bytes)) return vision::DecodePng(bytes, kMaxPicturePixels);
  if (IsJpeg(bytes)) return DecodeJpeg(bytes);
  return core::Fail(core::ErrorCode::kFormat, "neither JPEG nor PNG");
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
