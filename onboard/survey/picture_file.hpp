#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "vision/png.hpp"

namespace kawara::survey {

using Picture = vision::RgbPicture;

/// Larger pictures are refused before memory is asked for.
constexpr std::int64_t kMaxPicturePixels = 80'000'000;

/// JPEG or PNG, colour or grey (then all three are the same), 8 or 16 bits (the upper 8 are taken).
/// Pixels come as they are stored: an EXIF orientation is NOT followed, for calibrations are of the
/// sensor. Errors: kIo, kFormat.
core::Expected<Picture> DecodePicture(std::span<const std::uint8_t> bytes);
core::Expected<Picture> LoadPicture(const std::filesystem::path& file);

/// A whole file. Errors: kNotFound, kPermission, kIo.
core::Expected<std::vector<std::uint8_t>> ReadBytes(const std::filesystem::path& file);

}  // namespace kawara::survey
