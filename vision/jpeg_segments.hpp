#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace kawara::vision {

/// Largest payload of one JPEG marker segment: its 16-bit length counts itself.
constexpr std::size_t kMaxSegmentPayloadBytes = 65533;

constexpr std::string_view kExifSignature{"Exif\0\0", 6};
constexpr std::string_view kXmpSignature{"http://ns.adobe.com/xap/1.0/\0", 29};
constexpr std::string_view kJfifSignature{"JFIF\0", 5};

/// One marker segment before the picture data. `whole` includes marker and length, `payload`
/// neither.
struct JpegSegment {
  std::uint8_t marker = 0;
  std::span<const std::uint8_t> whole;
  std::span<const std::uint8_t> payload;

  bool Is(std::uint8_t wanted_marker, std::string_view signature) const;
};

constexpr std::uint8_t kMarkerApp0 = 0xE0;
constexpr std::uint8_t kMarkerApp1 = 0xE1;

/// A JPEG stream taken apart at its markers, without copying or decoding.
struct JpegSegments {
  std::vector<JpegSegment> header;     ///< between SOI and SOS, in order
  std::span<const std::uint8_t> scan;  ///< from SOS to the end of the bytes

  /// Payload of the first segment with that marker and signature, without the signature.
  std::optional<std::span<const std::uint8_t>> Find(std::uint8_t marker,
                                                    std::string_view signature) const;
  /// Width and height [px] of the coded picture, from its frame header (SOF).
  std::optional<std::pair<int, int>> PictureSize() const;
};

/// Empty: no SOI, or the markers break off before SOS.
std::optional<JpegSegments> SplitJpeg(std::span<const std::uint8_t> jpeg);

/// Appends marker, length, signature and payload. False (nothing written): longer than a segment
/// may be.
bool AppendSegment(std::uint8_t marker, std::string_view signature,
                   std::span<const std::uint8_t> payload, std::vector<std::uint8_t>* out);

}  // namespace kawara::vision
