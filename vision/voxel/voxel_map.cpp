#include "vision/voxel/voxel_map.hpp"

#include <algorithm>
#include <cmath>

#include "vision/voxel/spill_codec.hpp"

namespace kawara::vision {
namespace {

tl::unexpected<core::Error> Invalid(const char* what) {
  return core::Fail(core::ErrorCode::kInvalidArgument, std::string("voxel map: ") + what);
}

void PutVoxel(BlockGrid& grid, VoxelBlock& block, std::size_t place, const Voxel& voxel) {
  const std::uint16_t slot = grid.AddVoxel(block, place);  // may move block.voxels
  block.voxels[slot - 1] = voxel;
}

}  // namespace

core::Expected<VoxelMap> VoxelMap::Create(const VoxelMapConfig& config) {
  if (!(config.voxel_m >= 0.005 && config.voxel_m <= 10.0))
    return Invalid("voxel_m must be 0.005..10");
  if (!(config.min_range_m >= 0.0 && config.min_range_m < config.max_range_m))
    return Invalid("min_range_m must be at least 0 and less than max_range_m");
  // The window of blocks around the camera is addressed directly: its memory grows with the cube.
  if (!(config.max_range_m / config.voxel_m <= 800.0))
    return Invalid("max_range_m must be at most 800 voxels");
  if (!(config.max_sd_m > 0.0) || !(config.see_through_sigmas >= 0.0))
    return Invalid("max_sd_m must be more than 0, see_through_sigmas not less");
  return VoxelMap(config);
}

core::Expected<VoxelMap> VoxelMap::Open(const VoxelMapConfig& config,
                                        const std::string& spill_path) {
  auto map = Create(config);
  if (!map) return map;
  auto spill = SpillFile::Open(spill_path, config.voxel_m);
  if (!spill) return tl::unexpected(spill.error());
  map->pictures_ = spill->contents().pictures;
  map->spill_ = std::move(*spill);
  return map;
}

core::Expected<void> VoxelMap::CheckView(const RangeView& view) const {
  const RangeImage& r = view.ranges;
  if (r.width_px != view.rays.width_px() || r.height_px != view.rays.height_px() ||
      r.range_m.size() != view.rays.pixels() || r.sd_m.size() != view.rays.pixels())
    return Invalid("distance image of another size than the camera's");
  if (!view.picture.empty() &&
      (view.picture.width_px != r.width_px || view.picture.height_px != r.height_px))
    return Invalid("picture of another size than the distance image");
  if (!view.map_from_camera.matrix().allFinite()) return Invalid("a pose that is not finite");
  const double most_m = config_.voxel_m * kBlockSide * (BlockGrid::kMaxBlock - 1) -
                        config_.max_range_m - 2.0 * config_.voxel_m * kBlockSide;
  if (view.map_from_camera.translation().cwiseAbs().maxCoeff() > most_m)
    return Invalid("a pose too far from the map's origin");
  if (!(view.position_sd_m >= 0.0) || !(view.attitude_sd_rad >= 0.0))
    return Invalid("a pose with a negative deviation");
  return {};
}

double VoxelMap::HorizontalDistance(const TileIndex& tile,
                                    const Eigen::Vector3d& position_m) const {
  const double side = tile_m();
  const auto beyond = [&](std::int32_t index, double p) {
    return std::max({index * side - p, p - (index + 1.0) * side, 0.0});
  };
  return std::hypot(beyond(tile.x, position_m.x()), beyond(tile.y, position_m.y()));
}

core::Expected<void> VoxelMap::ReturnAround(const Eigen::Vector3d& position_m) {
  if (!spill_) return {};
  // A voxel more than the range: votes next to the border may round over it.
  const double reach_m = config_.max_range_m + config_.voxel_m;
  const auto tile_of = [&](double p) {
    return static_cast<std::int32_t>(std::floor(p / tile_m()));
  };
  for (std::int32_t x = tile_of(position_m.x() - reach_m); x <= tile_of(position_m.x() + reach_m);
       ++x) {
    for (std::int32_t y = tile_of(position_m.y() - reach_m); y <= tile_of(position_m.y() + reach_m);
         ++y) {
      if (auto back = Return({x, y}); !back) return back;
    }
  }
  return {};
}

core::Expected<void> VoxelMap::Return(const TileIndex& tile) {
  if (!spill_ || IsResident(tile) || !spill_->contents().tiles.contains(tile)) return {};
  auto bytes = spill_->Read(tile);
  if (!bytes) return tl::unexpected(bytes.error());
  TileDecoder decoder(*bytes, tile);
  SpilledBlock read;
  for (;;) {
    const auto more = decoder.Next(read);
    if (!more) {
      grid_.RemoveTile(tile);  // what came before the damage
      return core::Fail(more.error().code, spill_->path() + ": " + more.error().message);
    }
    if (!*more) break;
    VoxelBlock& block = grid_.FindOrMake(read.index);
    block.revision = read.revision;
    for (std::size_t i = 0; i < read.size; ++i)
      PutVoxel(grid_, block, read.places[i], read.voxels[i]);
  }
  if (IsResident(tile)) saved_revisions_[tile] = Revision(tile);
  ++counts_.tiles_returned;
  return {};
}

std::uint64_t VoxelMap::RevisionOf(const std::vector<VoxelBlock*>& blocks) const {
  std::uint64_t revision = 0;
  for (const VoxelBlock* block : blocks) revision = std::max(revision, block->revision);
  return revision;
}

std::uint64_t VoxelMap::Revision(const TileIndex& tile) const {
  const auto found = grid_.tiles().find(tile);
  return found == grid_.tiles().end() ? 0 : RevisionOf(found->second);
}

core::Expected<void> VoxelMap::Save(const TileIndex& tile) {
  const std::uint64_t revision = Revision(tile);
  auto& saved = saved_revisions_[tile];
  // Examine() dates what it changes with the last picture voted, which may have been saved already:
  // only a tile that no picture since has come near is known to be unchanged.
  if (saved == revision && revision != pictures_) return {};
  if (auto done = spill_->Append(tile, EncodeTile(grid_.tiles().at(tile))); !done) return done;
  saved = revision;
  return {};
}

core::Expected<void> VoxelMap::SpillBeyond(const Eigen::Vector3d& position_m, double keep_m) {
  if (!spill_) return {};
  std::vector<TileIndex> leaving;
  for (const auto& [tile, blocks] : grid_.tiles())
    if (HorizontalDistance(tile, position_m) > keep_m) leaving.push_back(tile);
  for (const TileIndex& tile : leaving) {
    if (auto saved = Save(tile); !saved) return saved;
    grid_.RemoveTile(tile);
    saved_revisions_.erase(tile);
    ++counts_.tiles_spilled;
  }
  return {};
}

core::Expected<void> VoxelMap::Commit(std::uint64_t progress) {
  if (!spill_) return {};
  for (const auto& [tile, blocks] : grid_.tiles())
    if (auto saved = Save(tile); !saved) return saved;
  return spill_->Commit(progress, pictures_);
}

std::vector<TileIndex> VoxelMap::Tiles() const {
  std::vector<TileIndex> all;
  for (const auto& [tile, blocks] : grid_.tiles()) all.push_back(tile);
  if (spill_)
    for (const auto& [tile, place] : spill_->contents().tiles)
      if (!IsResident(tile)) all.push_back(tile);
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<const VoxelBlock*> VoxelMap::BlocksWithin(const VoxelIndex& begin,
                                                      const VoxelIndex& end) const {
  std::vector<const VoxelBlock*> within;
  const auto outside = [](std::int32_t index, int bits, std::int32_t from, std::int32_t to) {
    const std::int64_t side = std::int64_t{1} << bits;
    return index * side + side <= from || index * side >= to;
  };
  for (const auto& [tile, blocks] : grid_.tiles()) {
    if (outside(tile.x, kTileBits, begin.x, end.x) || outside(tile.y, kTileBits, begin.y, end.y))
      continue;
    for (const VoxelBlock* block : blocks) {
      if (outside(block->index.x, kBlockBits, begin.x, end.x) ||
          outside(block->index.y, kBlockBits, begin.y, end.y) ||
          outside(block->index.z, kBlockBits, begin.z, end.z))
        continue;
      within.push_back(block);
    }
  }
  std::sort(within.begin(), within.end(),
            [](const VoxelBlock* a, const VoxelBlock* b) { return a->index < b->index; });
  return within;
}

const Voxel* VoxelMap::Find(const VoxelIndex& index) const {
  const VoxelBlock* block =
      grid_.Find({index.x >> kBlockBits, index.y >> kBlockBits, index.z >> kBlockBits});
  if (block == nullptr) return nullptr;
  const std::uint16_t slot =
      block->slot[static_cast<std::size_t>(VoxelInBlock(index.x, index.y, index.z))];
  return slot == 0 ? nullptr : &block->voxels[slot - 1];
}

std::size_t VoxelMap::memory_bytes() const {
  return grid_.memory_bytes() + window_.capacity() * sizeof(std::uintptr_t);
}

}  // namespace kawara::vision
