#include "vision/panorama_metadata.hpp"

#include <cstdio>

#include "vision/jpeg_segments.hpp"
#include "vision/panorama_blocks.hpp"

namespace kawara::vision {
namespace {

using Bytes = std::span<const std::uint8_t>;

core::Error NotJpeg() {
  return {core::ErrorCode::kFormat,
          "picture metadata: not a JPEG stream, or cut off in its header"};
}

std::string_view AsText(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Bytes AsBytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// The Exif payload: merged into the old block, or a new one where that is unreadable or the result
// outgrows a segment.
std::vector<std::uint8_t> ExifPayload(const std::optional<Bytes>& old,
                                      const PanoramaMetadata& metadata, const JpegSegments& parts) {
  const auto [width_px, height_px] = parts.PictureSize().value_or(std::pair{0, 0});
  std::optional<ExifBlock> block = old ? ExifBlock::Parse(*old) : std::nullopt;
  if (block) {
    WriteExifTags(metadata, width_px, height_px, &*block);
    std::vector<std::uint8_t> merged = block->Serialize();
    if (merged.size() + kExifSignature.size() <= kMaxSegmentPayloadBytes) return merged;
  }
  ExifBlock fresh;
  if (block) {  // too long: the camera's name at least is kept
    PanoramaMetadata before;
    ReadExifTags(*block, &before);
    fresh.SetAscii(ExifBlock::Directory::kPrimary, 0x010F, before.make);
    fresh.SetAscii(ExifBlock::Directory::kPrimary, 0x0110, before.model);
  }
  WriteExifTags(metadata, width_px, height_px, &fresh);
  return fresh.Serialize();
}

core::Expected<void> Insert(Bytes jpeg, const std::optional<JpegSegments>& old,
                            const PanoramaMetadata& metadata, std::vector<std::uint8_t>* out) {
  const auto parts = SplitJpeg(jpeg);
  if (!parts) return tl::unexpected(NotJpeg());
  std::optional<Bytes> old_exif, old_xmp;
  if (old) {
    old_exif = old->Find(kMarkerApp1, kExifSignature);
    old_xmp = old->Find(kMarkerApp1, kXmpSignature);
  }
  PanoramaMetadata complete = metadata;
  if (complete.geometry.width_px == 0 &&
      old_xmp) {  // the camera's own description of its panorama stays true
    PanoramaMetadata before;
    ReadXmpTags(AsText(*old_xmp), &before);
    complete.geometry = before.geometry;
  }
  const std::vector<std::uint8_t> exif = ExifPayload(old_exif, complete, *parts);
  const std::vector<XmpProperty> properties = XmpProperties(complete);
  std::string xmp =
      WriteXmpPacket(properties, old_xmp ? std::optional(AsText(*old_xmp)) : std::nullopt);
  if (xmp.size() + kXmpSignature.size() > kMaxSegmentPayloadBytes)
    xmp = WriteXmpPacket(properties, {});

  out->clear();
  out->reserve(jpeg.size() + exif.size() + xmp.size() + 256);
  out->insert(out->end(), {std::uint8_t{0xFF}, std::uint8_t{0xD8}});
  // Exif wants to be first; JFIF, whose density Exif repeats, is left out as cameras do.
  if (!AppendSegment(kMarkerApp1, kExifSignature, exif, out) ||
      !AppendSegment(kMarkerApp1, kXmpSignature, AsBytes(xmp), out)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "picture metadata: longer than a JPEG segment may be");
  }
  for (const JpegSegment& segment : parts->header) {
    const bool replaced = segment.Is(kMarkerApp1, kExifSignature) ||
                          segment.Is(kMarkerApp1, kXmpSignature) ||
                          segment.Is(kMarkerApp0, kJfifSignature);
    if (!replaced) out->insert(out->end(), segment.whole.begin(), segment.whole.end());
  }
  out->insert(out->end(), parts->scan.begin(), parts->scan.end());
  return {};
}

// FNV-1a, 64 bits.
std::uint64_t Hash(std::string_view text, std::uint64_t seed) {
  std::uint64_t hash = 0xcbf29ce484222325ULL ^ seed;
  for (char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3ULL;
  }
  return hash;
}

}  // namespace

core::Expected<void> InsertPanoramaMetadata(Bytes jpeg, const PanoramaMetadata& metadata,
                                            std::vector<std::uint8_t>* out) {
  return Insert(jpeg, SplitJpeg(jpeg), metadata, out);
}

core::Expected<void> InsertPanoramaMetadata(Bytes jpeg, Bytes original,
                                            const PanoramaMetadata& metadata,
                                            std::vector<std::uint8_t>* out) {
  return Insert(jpeg, SplitJpeg(original), metadata, out);
}

core::Expected<PanoramaMetadata> ReadPanoramaMetadata(Bytes jpeg) {
  const auto parts = SplitJpeg(jpeg);
  if (!parts) return tl::unexpected(NotJpeg());
  PanoramaMetadata metadata;
  metadata.software.clear();
  if (const auto payload = parts->Find(kMarkerApp1, kExifSignature)) {
    if (const auto exif = ExifBlock::Parse(*payload)) ReadExifTags(*exif, &metadata);
  }
  if (const auto payload = parts->Find(kMarkerApp1, kXmpSignature))
    ReadXmpTags(AsText(*payload), &metadata);
  return metadata;
}

std::string ImageUniqueId(const PanoramaMetadata& m) {
  const std::string identity = m.robot + '\n' + m.mission + '\n' + std::to_string(m.epoch) + '\n' +
                               std::to_string(m.time ? m.time->ns() : 0) + '\n' +
                               std::to_string(m.geometry.width_px) + '\n' + m.make + '\n' + m.model;
  char text[33];
  std::snprintf(text, sizeof text, "%016llx%016llx",
                static_cast<unsigned long long>(Hash(identity, 0)),
                static_cast<unsigned long long>(Hash(identity, 0x9e3779b97f4a7c15ULL)));
  return text;
}

}  // namespace kawara::vision
