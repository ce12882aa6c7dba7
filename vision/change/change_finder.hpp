#pragma once
#include <vector>

#include "core/changed_object.hpp"
#include "vision/change/box_fit.hpp"
#include "vision/change/change_points.hpp"
#include "vision/change/change_regions.hpp"
#include "vision/change/road_axis.hpp"
#include "vision/change/road_width.hpp"

namespace kawara::vision {

enum class ChangeMethod {
  kBest,   ///< tolerances from deviations, likelihood of sides
  kPaper,  ///< 50 cm voxels of the reference left out, boxes by projection: Meguro et al., section
           ///< 5
};

struct FinderOptions {
  ChangeMethod method = ChangeMethod::kBest;
  ChangeOptions change;
  RegionOptions region;
  BoxOptions box;
  WidthOptions width;
};

/// Options of the paper's method: a voxel of enough votes within half a metre of the reference is
/// the reference, whatever the deviations; nothing is asked of who saw it.
FinderOptions PaperFinder();

/// An object as far as one look knows it: uid, revision and times are the tracker's to give.
struct FoundChange {
  core::ChangedObject object;
  ChangeRegion region;
};

struct Findings {
  std::vector<FoundChange> changes;  ///< largest first
  ChangePoints look;
  std::vector<core::RoadStation> stations;
};

/// The whole of the 3rd update on what a voxel map knows now: changed surfaces, regions, boxes with
/// their accuracy, and the road they leave. `axes` may be empty: then no stations and no weight of
/// the road's direction.
Findings FindChanges(const VoxelMap& map, const RoadArea& road, const std::vector<RoadAxis>& axes,
                     const GroundField& ground, const ReferenceMap& reference,
                     const Eigen::Isometry3d& reference_from_map, const FinderOptions& options);

}  // namespace kawara::vision
