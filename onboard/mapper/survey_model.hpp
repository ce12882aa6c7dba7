#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>

#include "core/expected.hpp"

namespace kawara::mapper {

/// What `kawara-mapper SURVEY --out DIR` is asked for.
struct ModelOptions {
  std::filesystem::path survey;
  std::filesystem::path out = ".";
  double nearest_m = 1.5;
  double px_per_rad = 0.0;  ///< of the search; 0: the camera's own
  double baseline_m = 0.5;  ///< between the two frames of a pair, at least
  double step_m = 0.25;     ///< between the first frames of two pairs, at least
  double voxel_m = 0.10;
  double reach_m = 8.0;  ///< ranges beyond are not voted
};

struct ModelResult {
  std::size_t pairs = 0;
  std::size_t tiles = 0;
  std::size_t quads = 0;
  double seconds = 0.0;
  std::filesystem::path vrml;  ///< the whole model: a file that draws in those of the tiles
};

/// How far it is: pairs done, of all.
using ModelProgress = std::function<void(std::size_t done, std::size_t all)>;

/// The textured 3D model of a survey (the paper's section 4, its 2nd update): distance images of
/// pairs along the drive, votes in voxels, a surface and a texture for each tile. Writes
/// tile_X_Y.wrl and .glb, model.wrl, and, of a survey with geodetic poses, tileset.json over the
/// GLBs and points.las. Pictures wait in memory only while a tile in their reach is open; voxels
/// and points stay, so that memory grows with the area. Errors: the survey's; kFormat: no pair at
/// the baseline, or nothing in the pictures to measure.
core::Expected<ModelResult> BuildSurveyModel(const ModelOptions& options,
                                             const ModelProgress& progress);

}  // namespace kawara::mapper
