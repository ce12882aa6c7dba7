#pragma once
#include <optional>
#include <vector>

#include "core/changed_object.hpp"
#include "vision/change/box_fit.hpp"
#include "vision/change/change_points.hpp"
#include "vision/change/change_regions.hpp"
#include "vision/change/known_place.hpp"
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
  std::optional<PlaneDisc> within;  ///< elsewhere nobody looked
  /// Unit vector: what lies ahead of a line across `within`'s centre has not been looked at enough
  /// to be called gone. Not set: everything has.
  std::optional<Eigen::Vector2d> ahead;
};

/// The whole of the 3rd update on what a voxel map knows now: changed surfaces, regions, boxes with
/// their accuracy, and the road they leave. A place without axes: no stations and no weight of the
/// road's direction. `within`: only there is looked, and stations are measured, as in the middle of
/// a drive.
Findings FindChanges(const VoxelMap& map, const KnownPlace& place,
                     const Eigen::Isometry3d& reference_from_map, const FinderOptions& options,
                     const std::optional<PlaneDisc>& within = {});

}  // namespace kawara::vision
