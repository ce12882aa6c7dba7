#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "vision/change/reference_map.hpp"

namespace kawara::vision {

struct ReferenceBuildOptions {
  /// A voxel with fewer points is noise. Of surfaces given as triangles any number counts.
  std::uint32_t min_points = 3;
  /// Ground is the lowest level patch of a column; deviation of its height beyond the source's.
  double ground_sd_m = 0.03;
  /// Patches whose normal is steeper than this are no ground.
  double ground_slope = 0.5;
};

/// Points and surfaces to a reference map, streaming: 50 cm voxels hold sums only, so that memory
/// follows the place and not the points. One thread.
class ReferenceBuilder {
 public:
  explicit ReferenceBuilder(const ReferenceBuildOptions& options = {});
  ~ReferenceBuilder();
  ReferenceBuilder(ReferenceBuilder&&) noexcept;
  ReferenceBuilder& operator=(ReferenceBuilder&&) noexcept;

  /// Everything added from now on is of this source. Of more than 65,535 different ones the last
  /// stands for the rest.
  void Begin(const ReferenceSource& source);
  /// Points of the map's frame; those that are not finite or out of the world are left out.
  void AddPoints(std::span<const Eigen::Vector3d> points_m);
  /// A flat face of a building with holes (the first ring is the outer one, none closed), as if it
  /// had been measured every 10 cm.
  void AddFace(const std::vector<std::vector<Eigen::Vector3d>>& rings_m);

  std::uint64_t points() const { return points_; }
  /// Planes of all voxels; ground where nothing better is known (`ground_from_surfaces`).
  ReferenceMap Finish(bool ground_from_surfaces) const;

 private:
  struct Block;
  struct Sums;
  Sums& SumsAt(const VoxelIndex& voxel);
  void Add(const Eigen::Vector3d& p);
  void FindGround(ReferenceMap& map) const;

  ReferenceBuildOptions options_;
  std::vector<ReferenceSource> sources_;
  std::unordered_map<std::int64_t, std::unique_ptr<Block>> blocks_;
  Block* last_ = nullptr;
  std::int64_t last_key_ = 0;
  std::uint64_t points_ = 0;
  bool surfaces_ = false;
  std::uint16_t source_ = 0;  ///< of sources_: what is added now
};

}  // namespace kawara::vision
