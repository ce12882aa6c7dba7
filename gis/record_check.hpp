#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/expected.hpp"
#include "gis/records.hpp"

/// What a row of the store may hold. Records come over a radio: nothing in them is believed.
namespace kawara::gis {

constexpr std::size_t kMaxNameBytes = 64;
constexpr std::size_t kMaxTextBytes = 1000;
constexpr std::size_t kMaxJpegBytes = std::size_t{64} << 20;

/// Names: 1..64 bytes of UTF-8 without control characters. Times: 2000..2200. Latitude, longitude,
/// height in range and finite; accuracies and velocities finite or NaN. Pictures: CheckJpeg, of the
/// stated size. kInvalidArgument with the first thing that is wrong.
core::Expected<void> CheckRecord(const PoseRecord& record);
core::Expected<void> CheckRecord(const PanoramaRecord& record);
core::Expected<void> CheckRecord(const EventRecord& record);

/// UTF-8 without control characters or overlong forms, at most `max_bytes`.
bool IsCleanText(std::string_view text, std::size_t max_bytes);
/// The same text made clean: what is not becomes '?', cut at a character's end. For people's eyes
/// only.
std::string CleanText(std::string_view text, std::size_t max_bytes);

/// One path component for any clean name: [A-Za-z0-9._-], never empty, hidden or "..". A name with
/// other characters gets them replaced and a checksum of the original appended, so that two names
/// never share a folder by that.
std::string SafePathName(std::string_view name);

struct JpegSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};
/// Walks the segments of a JPEG from SOI to SOS without decoding; EOI must be the last marker.
/// kFormat if torn. Source: ITU-T T.81, B.1-B.2.
core::Expected<JpegSize> CheckJpeg(std::span<const std::uint8_t> bytes);

}  // namespace kawara::gis
