#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "vision/voxel/block_grid.hpp"
#include "vision/voxel/range_view.hpp"
#include "vision/voxel/spill_file.hpp"
#include "vision/voxel/voxel.hpp"

namespace kawara::vision {

struct VoxelMapConfig {
  double voxel_m = 0.10;
  double min_range_m = 0.3;
  double max_range_m = 8.0;  ///< votes from farther away are dropped
  double max_sd_m = 0.5;     ///< and those less certain (pose included)
  /// A voxel is seen through by a range that exceeds its distance by this many deviations and a
  /// voxel's half diagonal.
  double see_through_sigmas = 3.0;
};

/// One measured point, of a laser or of anybody's cloud.
struct PointVote {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< map
  /// Unit vector to where it was measured from; zero: nobody knows.
  Eigen::Vector3f to_viewer = Eigen::Vector3f::Zero();
  float sd_m = 0.03F;
  std::array<std::uint8_t, 3> colour{};
};

/// Counts since construction.
struct VoxelMapCounts {
  std::uint64_t pictures = 0;
  std::uint64_t votes = 0;
  std::uint64_t dropped_far = 0;        ///< known ranges outside min..max
  std::uint64_t dropped_uncertain = 0;  ///< or with too large a deviation
  std::uint64_t seen_through = 0;       ///< voxels told so, once a picture
  std::uint64_t tiles_spilled = 0, tiles_returned = 0;
};

/// A voxel for the reader. Its reference is good during the call.
struct OccupiedVoxel {
  VoxelIndex index;
  const Voxel& voxel;
};

/// Votes of distance images in a sparse voxel space, the paper's step against errors (section 4C),
/// streaming: pictures are added as they come, several visits add up, tiles left behind wait in a
/// file. Frame: `map`, local east-north-up [m].
///
/// A vote weighs 1 / (sd^2 + position_sd^2 + (attitude_sd * range)^2). Free space is not carved
/// along rays; instead every occupied voxel near the camera is looked up in the distance image
/// (Examine): what lies clearly in front of the measured surface was looked through, and by as many
/// rays as its size covers pixels, so that the evidence is in the unit of votes.
///
/// The same calls in the same order give the same bytes, on any machine of IEEE floats and whatever
/// was spilled in between. One writer; const methods from any thread while nothing is written.
class VoxelMap {
 public:
  /// Errors: kInvalidArgument.
  static core::Expected<VoxelMap> Create(const VoxelMapConfig& config);
  /// With a spill file, created or gone on from its last Commit. Errors: those of SpillFile::Open.
  static core::Expected<VoxelMap> Open(const VoxelMapConfig& config, const std::string& spill_path);

  /// Votes of one picture; tiles in reach come back first. Errors: kInvalidArgument (sizes differ,
  /// a pose that is not finite or out of the world), those of the spill file; then nothing was
  /// added.
  core::Expected<void> Vote(const RangeView& view);
  /// Votes of points without a picture; no limit of range. Counts as one picture. A point that is
  /// not finite or out of the world is left out and counted as dropped_far. Tiles that are spilled
  /// come back first.
  core::Expected<void> Vote(std::span<const PointVote> points);
  /// See-through evidence of one picture. Errors as of Vote.
  core::Expected<void> Examine(const RangeView& view);

  /// Writes out and forgets all tiles whose nearest point is farther than `keep_m` from
  /// `position_m` (horizontally). At least max_range_m, or they come back with the next picture.
  /// Without a spill file nothing happens.
  core::Expected<void> SpillBeyond(const Eigen::Vector3d& position_m, double keep_m);
  /// Everything up to here survives a kill or a power cut. `progress` is the caller's own, returned
  /// by progress() after Open (e.g. the number of the last picture). Without a spill file: nothing.
  core::Expected<void> Commit(std::uint64_t progress);
  std::uint64_t progress() const { return spill_ ? spill_->contents().progress : 0; }
  /// Voted pictures, over kills and restarts.
  std::uint64_t pictures() const { return pictures_; }
  /// Records of the spill file that were damaged and left out when it was opened.
  std::uint64_t damaged_records() const { return spill_ ? spill_->contents().damaged_records : 0; }

  /// All there are, in memory or not, in order.
  std::vector<TileIndex> Tiles() const;
  bool IsResident(const TileIndex& tile) const { return grid_.tiles().contains(tile); }
  /// Brings a tile back into memory if it was spilled.
  core::Expected<void> Return(const TileIndex& tile);
  /// Number of the picture that last changed a tile that is in memory; 0: not in memory.
  std::uint64_t Revision(const TileIndex& tile) const;
  /// Metres of a tile's side.
  double tile_m() const { return config_.voxel_m * kTileSide; }

  /// Calls visit(OccupiedVoxel) for every voxel in memory the rule accepts within [begin, end), in
  /// an order that depends on the contents only.
  template <class Visit>
  void ForEachOccupied(const VoxelIndex& begin, const VoxelIndex& end, const OccupancyRule& rule,
                       const Visit& visit) const;
  /// All in memory.
  template <class Visit>
  void ForEachOccupied(const OccupancyRule& rule, const Visit& visit) const;
  /// Null: never hit, or not in memory.
  const Voxel* Find(const VoxelIndex& index) const;

  const VoxelMapConfig& config() const { return config_; }
  const VoxelMapCounts& counts() const { return counts_; }
  std::size_t memory_bytes() const;

 private:
  explicit VoxelMap(const VoxelMapConfig& config) : config_(config) {}
  core::Expected<void> CheckView(const RangeView& view) const;
  core::Expected<void> ReturnAround(const Eigen::Vector3d& position_m);
  core::Expected<void> Save(const TileIndex& tile);
  std::uint64_t RevisionOf(const std::vector<VoxelBlock*>& blocks) const;
  /// Blocks of the tiles touching [begin, end), sorted by index.
  std::vector<const VoxelBlock*> BlocksWithin(const VoxelIndex& begin, const VoxelIndex& end) const;
  double HorizontalDistance(const TileIndex& tile, const Eigen::Vector3d& position_m) const;

  VoxelMapConfig config_;
  BlockGrid grid_;
  std::optional<SpillFile> spill_;
  std::map<TileIndex, std::uint64_t> saved_revisions_;  ///< of tiles in memory
  std::uint64_t pictures_ = 0;  ///< numbers them over kills and restarts; counts_ starts anew
  VoxelMapCounts counts_;
  std::vector<VoxelBlock*> window_;  ///< blocks around the camera, filled while voting
};

}  // namespace kawara::vision

#include "vision/voxel/voxel_map_visit.hpp"
