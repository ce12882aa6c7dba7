#pragma once
#include <filesystem>
#include <string>

#include "core/expected.hpp"
#include "gis/map_overlay.hpp"

namespace kawara::gis {

struct TrackMapOptions {
  int width_px = 1600;
  int height_px = 1100;
};

/// Draws what a store knows of its robots as one PNG, without network and map tiles: the tracks
/// coloured by RTK state, the pictures with their headings, start and end, a metric grid about the
/// first pose with its coordinates, scale bar, north arrow, legend, and the time covered. Metres
/// east and north in the tangent plane, north up. The same store gives the same pixels. Errors:
/// kNotFound (no store, nothing in it), kIo, kFull.
core::Expected<void> DrawTrackMap(const std::string& store, const std::filesystem::path& png,
                                  const TrackMapOptions& options = {},
                                  const MapOverlay& overlay = {});

}  // namespace kawara::gis
