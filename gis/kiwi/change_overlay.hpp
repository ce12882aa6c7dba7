#pragma once
#include <string>

#include "core/expected.hpp"
#include "gis/map_overlay.hpp"

namespace kawara::gis {

/// What stands and the road it leaves, for DrawTrackMap: boxes by class with their uid and size,
/// stations by what passes. Empty: the store has no register. Errors: those of opening a store.
core::Expected<MapOverlay> LoadChangeOverlay(const std::string& store);

}  // namespace kawara::gis
