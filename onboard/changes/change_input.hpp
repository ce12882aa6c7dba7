#pragma once
#include <cstdint>
#include <optional>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "onboard/changes/change_run.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::changes {

/// What a run looks at.
struct ChangeInput {
  vision::VoxelMap map;
  std::optional<core::Geodetic> origin;
  std::uint64_t points = 0;
  bool from_pictures =
      false;  ///< votes of distance images: many a voxel, with see-through evidence
};

/// Clouds into voxels, or the voxels of a model's folder. `origin`: of the map, if it is known
/// already. Errors: those of the files.
core::Expected<ChangeInput> ReadInput(const ChangeRunOptions& options,
                                      const std::optional<core::Geodetic>& origin);

}  // namespace kawara::changes
