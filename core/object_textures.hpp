#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "core/time.hpp"

/// What the sides of a changed object look like. `vision` makes it, `gis` keeps it.
namespace kawara::core {

/// Where one side of a box is in its atlas, and where that picture came from.
struct FaceTexture {
  BoxSide side = BoxSide::kFront;
  /// Corners in the atlas [px from the upper left], looking at the side from outside: upper left,
  /// upper right, lower right, lower left. Of the top: looking down with the front upwards.
  std::array<std::array<double, 2>, 4> corners_px{};
  std::string source = {};  ///< of the picture: its uri or "mission/epoch"
  UtcTime taken;            ///< mid-exposure; not set: unknown
  double seen_share = 1.0;  ///< of the side's area that pictures show, 0..1; the rest is made up
};

/// The pictures of a box's sides in one JPEG. Without atlas: no textures.
struct ObjectTextures {
  std::vector<std::uint8_t> atlas_jpeg;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::vector<FaceTexture> faces;
};

}  // namespace kawara::core
