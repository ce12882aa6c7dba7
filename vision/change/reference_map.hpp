#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "vision/change/ground_field.hpp"
#include "vision/change/road_area.hpp"
#include "vision/voxel/voxel.hpp"

namespace kawara::vision {

/// What a part of the reference was made from.
struct ReferenceSource {
  std::string name;    ///< file or survey
  std::string kind;    ///< "laser", "city model", "footprints", "raster", "cloud", "survey"
  core::UtcTime date;  ///< when it was true; not set: nobody says
  double sd_m = 0.0;   ///< one standard deviation of its surfaces
};

/// Surface within a voxel of the reference: the paper's 50 cm voxel (section 5 B 1), and where in
/// it the surface lies.
struct ReferencePatch {
  Eigen::Vector3f mean_m = Eigen::Vector3f::Zero();   ///< from the voxel's centre
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  ///< unit; its sign means nothing
  float thickness_m = 0.0F;                           ///< rms of the points along the normal
  float sd_m = 0.0F;                                  ///< of the source
  std::uint32_t points = 0;
  std::uint16_t source = 0;  ///< the newest that put points here
};

/// How a surface point stands to the reference.
struct ReferenceMatch {
  double distance_m = 0.0;  ///< from the patch
  double signed_m = 0.0;    ///< along its normal
  double sd_m = 0.0;        ///< of the patch: source and thickness
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

/// What stood there before: surfaces, ground and road, each with its accuracy and date. Frame: map,
/// local east-north-up [m] at `origin`. Made by ReferenceBuilder, kept by reference_file.hpp.
/// Reading from any thread while nothing is written.
class ReferenceMap {
 public:
  static constexpr double kVoxel = 0.5;  ///< [m]: the paper's

  std::optional<core::Geodetic> origin;  ///< of the map; nothing: a place of its own
  std::vector<ReferenceSource> sources;
  GroundField ground;
  std::vector<RoadPolygon> roads;
  std::vector<std::pair<std::string, std::vector<Eigen::Vector2d>>> road_axes;  ///< if a GIS knows

  void SetPatch(const VoxelIndex& voxel, const ReferencePatch& patch) {
    patches_[KeyOf(voxel)] = {voxel, patch};
  }
  void Reserve(std::size_t patches) { patches_.reserve(patches); }
  std::size_t patches() const { return patches_.size(); }
  /// In order of their index.
  std::vector<std::pair<VoxelIndex, ReferencePatch>> Patches() const;
  /// Null: nothing stood there.
  const ReferencePatch* Find(const VoxelIndex& voxel) const;
  static VoxelIndex VoxelOf(const Eigen::Vector3d& p);

  /// The patch about `p` that lies nearest, within `reach_m`: its plane, as far
  /// as its voxel reaches. Nothing: no reference there.
  std::optional<ReferenceMatch> Nearest(const Eigen::Vector3d& p, double reach_m) const;

  /// Newest date of a source; not set: none says.
  core::UtcTime Date() const;

 private:
  static std::int64_t KeyOf(const VoxelIndex& v);

  std::unordered_map<std::int64_t, std::pair<VoxelIndex, ReferencePatch>> patches_;
};

}  // namespace kawara::vision
