#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "core/time.hpp"

namespace kawara::gis {

/// Where one side of a box is in its atlas, and where that picture came from.
struct FaceTexture {
  core::BoxSide side = core::BoxSide::kFront;
  /// Corners in the atlas [px from the upper left], looking at the side from outside: upper left,
  /// upper right, lower right, lower left. Of the top: looking down with the front upwards.
  std::array<std::array<double, 2>, 4> corners_px{};
  std::string source = {};  ///< of the picture: its uri or "mission/epoch"
  core::UtcTime taken;      ///< mid-exposure; not set: unknown
};

/// The pictures of a box's sides in one JPEG. Without atlas: no textures.
struct ObjectTextures {
  std::vector<std::uint8_t> atlas_jpeg;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::vector<FaceTexture> faces;
};

}  // namespace kawara::gis
