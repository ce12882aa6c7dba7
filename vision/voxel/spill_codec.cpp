#include "vision/voxel/spill_codec.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "vision/voxel/block_grid.hpp"

namespace kawara::vision {
namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(std::is_trivially_copyable_v<Voxel>);

template <class T>
void Put(std::vector<std::uint8_t>& bytes, const T& value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

tl::unexpected<core::Error> Wrong(const char* what) {
  return core::Fail(core::ErrorCode::kFormat, what);
}

bool IsPossible(const Voxel& v) {
  if (v.hits == 0 || !std::isfinite(v.weight) || !(v.weight > 0.0F)) return false;
  for (const float m : v.moment) {
    // Votes lie in the voxel: half a voxel from its centre, and rounding of many sums.
    if (!(std::abs(m) <= 0.51F * v.weight)) return false;
  }
  for (const std::int16_t c : v.colour)
    if (c < 0 || c > 255 * Voxel::kColourOne) return false;
  for (const std::int16_t d : v.to_viewer)
    if (std::abs(int{d}) > Voxel::kViewOne + 1) return false;
  return true;
}

}  // namespace

std::vector<std::uint8_t> EncodeTile(std::span<VoxelBlock* const> blocks) {
  std::vector<std::uint8_t> bytes;
  Put(bytes, static_cast<std::uint32_t>(blocks.size()));
  for (const VoxelBlock* block : blocks) {
    Put(bytes, block->index);
    Put(bytes, block->revision);
    Put(bytes, block->any);
    block->ForEach([&](std::size_t, const Voxel& voxel) { Put(bytes, voxel); });
  }
  return bytes;
}

template <class T>
bool TileDecoder::Take(T& value) {
  if (bytes_.size() < sizeof(T)) return false;
  std::memcpy(&value, bytes_.data(), sizeof(T));
  bytes_ = bytes_.subspan(sizeof(T));
  return true;
}

core::Expected<bool> TileDecoder::Next(SpilledBlock& block) {
  if (!begun_ && !Take(left_)) return Wrong("no number of blocks");
  begun_ = true;
  if (left_ == 0) {
    if (!bytes_.empty()) return Wrong("bytes after the last block");
    return false;
  }
  --left_;
  std::array<std::uint64_t, kBlockVoxels / 64> any{};
  if (!Take(block.index) || !Take(block.revision) || !Take(any))
    return Wrong("ends within a block");
  constexpr std::int64_t kMost = BlockGrid::kMaxBlock;
  for (const std::int64_t c : {block.index.x, block.index.y, block.index.z})
    if (c < -kMost || c > kMost) return Wrong("a block out of the world");
  if (TileOfBlock(block.index) != tile_) return Wrong("a block of another tile");
  block.size = 0;
  for (std::size_t word = 0; word < any.size(); ++word) {
    for (std::uint64_t bits = any[word]; bits != 0; bits &= bits - 1) {
      Voxel& voxel = block.voxels[block.size];
      block.places[block.size++] =
          static_cast<std::uint16_t>(word * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
      if (!Take(voxel)) return Wrong("ends within a block's voxels");
      if (!IsPossible(voxel)) return Wrong("a voxel that no votes can make");
    }
  }
  return true;
}

}  // namespace kawara::vision
