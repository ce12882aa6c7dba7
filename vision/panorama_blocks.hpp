#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "vision/exif_block.hpp"
#include "vision/panorama_metadata.hpp"
#include "vision/xmp_packet.hpp"

/// The two vocabularies of PanoramaMetadata, each written and read in one place: panorama_exif.cpp,
/// panorama_xmp.cpp. Readers fill only what they find and leave the rest of the object alone.
namespace kawara::vision {

/// Sets the tags; `width_px` and `height_px` are the coded picture's. Camera tags (exposure, ...)
/// are not touched.
void WriteExifTags(const PanoramaMetadata& metadata, int width_px, int height_px, ExifBlock* exif);
void ReadExifTags(const ExifBlock& exif, PanoramaMetadata* metadata);

std::vector<XmpProperty> XmpProperties(const PanoramaMetadata& metadata);
void ReadXmpTags(std::string_view packet, PanoramaMetadata* metadata);

/// "2026-11-22T15:03:22.123456789Z"; nothing if that is not what the text is.
std::string IsoTime(core::UtcTime time);
std::optional<core::UtcTime> ParseIsoTime(std::string_view text);

/// Fixed notation, independent of locale.
std::string FixedText(double value, int decimals);

}  // namespace kawara::vision
