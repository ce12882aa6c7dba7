#include "vision/jpeg_segments.hpp"

#include <algorithm>

namespace kawara::vision {
namespace {

constexpr std::uint8_t kMarkerSoi = 0xD8;
constexpr std::uint8_t kMarkerSos = 0xDA;

// TEM, RSTn, SOI, EOI stand alone; none of them belongs between SOI and SOS, so they are skipped if
// they occur.
bool StandsAlone(std::uint8_t marker) {
  return marker == 0x01 || (marker >= 0xD0 && marker <= 0xD9);
}

}  // namespace

bool JpegSegment::Is(std::uint8_t wanted_marker, std::string_view signature) const {
  return marker == wanted_marker && payload.size() >= signature.size() &&
         std::equal(signature.begin(), signature.end(), payload.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

std::optional<std::span<const std::uint8_t>> JpegSegments::Find(std::uint8_t marker,
                                                                std::string_view signature) const {
  for (const JpegSegment& segment : header) {
    if (segment.Is(marker, signature)) return segment.payload.subspan(signature.size());
  }
  return {};
}

std::optional<std::pair<int, int>> JpegSegments::PictureSize() const {
  for (const JpegSegment& segment : header) {
    const std::uint8_t m = segment.marker;
    // SOF0..SOF15 without DHT, JPG and DAC, which share the range.
    const bool is_frame = m >= 0xC0 && m <= 0xCF && m != 0xC4 && m != 0xC8 && m != 0xCC;
    if (!is_frame || segment.payload.size() < 5) continue;
    return std::pair{segment.payload[3] << 8 | segment.payload[4],
                     segment.payload[1] << 8 | segment.payload[2]};
  }
  return {};
}

std::optional<JpegSegments> SplitJpeg(std::span<const std::uint8_t> jpeg) {
  if (jpeg.size() < 4 || jpeg[0] != 0xFF || jpeg[1] != kMarkerSoi) return {};
  JpegSegments parts;
  std::size_t at = 2;
  while (at + 4 <= jpeg.size()) {
    if (jpeg[at] != 0xFF) return {};
    const std::uint8_t marker = jpeg[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (StandsAlone(marker)) {
      at += 2;
      continue;
    }
    if (marker == kMarkerSos) {
      parts.scan = jpeg.subspan(at);
      return parts;
    }
    const std::size_t length = std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3];
    if (length < 2 || at + 2 + length > jpeg.size()) return {};
    parts.header.push_back(
        {marker, jpeg.subspan(at, 2 + length), jpeg.subspan(at + 4, length - 2)});
    at += 2 + length;
  }
  return {};
}

bool AppendSegment(std::uint8_t marker, std::string_view signature,
                   std::span<const std::uint8_t> payload, std::vector<std::uint8_t>* out) {
  const std::size_t size = signature.size() + payload.size();
  if (size > kMaxSegmentPayloadBytes) return false;
  const std::size_t length = size + 2;
  out->insert(out->end(), {std::uint8_t{0xFF}, marker, static_cast<std::uint8_t>(length >> 8),
                           static_cast<std::uint8_t>(length & 0xFF)});
  out->insert(out->end(), signature.begin(), signature.end());
  out->insert(out->end(), payload.begin(), payload.end());
  return true;
}

}  // namespace kawara::vision
