#pragma once
#include <filesystem>
#include <vector>

#include "core/expected.hpp"
#include "core/textured_mesh.hpp"

namespace kawara::gis {

/// The corners of a PLY file as points in the file's own frame [m], 0 votes each: binary
/// little-endian, element vertex first, with x, y, z as float or double and red, green, blue as
/// uchar; other numbers of a corner are passed over, and so is whatever follows the corners. What
/// WritePlyMesh writes is read. Source: G. Turk, "The PLY Polygon File Format" (1994). Errors:
/// kNotFound, kPermission, kIo; kFormat for anything else than said above, or a file that ends
/// before its corners do.
core::Expected<std::vector<core::ColouredPoint>> ReadPlyPoints(const std::filesystem::path& path);

}  // namespace kawara::gis
