#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "vision/voxel/vote_batch.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {
namespace {

// 128 bits, which every machine has: GCC's and clang's own vectors need no dispatch.
using Floats = float __attribute__((vector_size(16)));
using Shorts = std::int16_t __attribute__((vector_size(16)));

template <class V>
V LoadVector(const void* from) {
  V v;
  std::memcpy(&v, from, sizeof(v));
  return v;
}

static_assert(offsetof(Voxel, moment) == 0 && offsetof(Voxel, weight) == 12 &&
              offsetof(Voxel, colour) == 16 && offsetof(Voxel, to_viewer) == 22 &&
              offsetof(Voxel, hits) == 28);

// 32768 / n: gain of a running mean over n votes.
constexpr auto kGains = [] {
  std::array<std::int16_t, Voxel::kMeanVotes + 1> gains{};
  for (int n = 2; n <= Voxel::kMeanVotes; ++n)
    gains[static_cast<std::size_t>(n)] = static_cast<std::int16_t>(32768 / n);
  return gains;
}();

/// Cube of blocks around the camera, addressed directly instead of by hash. Local coordinates are
/// never negative.
struct Window {
  VoxelIndex first;  ///< voxel, a multiple of 8
  int side_blocks = 0;
  Eigen::Vector3f camera;  ///< [voxels] from `first`

  Window(const Eigen::Vector3d& camera_m, const VoxelMapConfig& config) {
    const Eigen::Vector3d voxels = camera_m / config.voxel_m;
    const double reach = config.max_range_m / config.voxel_m + 1.0;
    const auto begin = [&](int axis) {
      return static_cast<std::int32_t>(std::floor((voxels[axis] - reach) / kBlockSide)) *
             kBlockSide;
    };
    first = {begin(0), begin(1), begin(2)};
    side_blocks = static_cast<int>(std::ceil(2.0 * reach / kBlockSide)) + 1;
    camera = (voxels - Eigen::Vector3d(first.x, first.y, first.z)).cast<float>();
  }
  std::size_t size() const {
    const auto side = static_cast<std::size_t>(side_blocks);
    return side * side * side;
  }
};

/// Fills a batch with the pixels from `pixel` on whose ranges are fit to vote.
class Picker {
 public:
  Picker(const RangeView& view, const VoxelMapConfig& config, VoxelMapCounts& counts)
      : view_(view),
        counts_(counts),
        least_m_(static_cast<float>(config.min_range_m)),
        most_m_(static_cast<float>(config.max_range_m)),
        most_variance_(static_cast<float>(config.max_sd_m * config.max_sd_m)),
        position_variance_(static_cast<float>(view.position_sd_m * view.position_sd_m)),
        attitude_variance_(static_cast<float>(view.attitude_sd_rad * view.attitude_sd_rad)) {}

  /// Returns where to go on.
  std::size_t Fill(VoteBatch& batch, std::size_t pixel) {
    const float* const range = view_.ranges.range_m.data();
    const float* const sd = view_.ranges.sd_m.data();
    const float* const x = view_.rays.x();
    const float* const y = view_.rays.y();
    const float* const z = view_.rays.z();
    const std::size_t pixels = view_.rays.pixels();
    batch.size = 0;
    for (; pixel < pixels && batch.size < VoteBatch::kMost; ++pixel) {
      const float r = range[pixel];
      if (std::isnan(r) || std::isnan(x[pixel])) continue;
      if (!(r >= least_m_ && r <= most_m_)) {
        ++counts_.dropped_far;
        continue;
      }
      const float variance =
          sd[pixel] * sd[pixel] + position_variance_ + attitude_variance_ * r * r;
      if (!(variance <= most_variance_)) {
        ++counts_.dropped_uncertain;
        continue;
      }
      const std::size_t i = batch.size++;
      batch.pixel[i] = static_cast<std::uint32_t>(pixel);
      batch.range_m[i] = r;
      batch.weight[i] = 1.0F / std::max(variance, kLeastVariance);
      batch.x[i] = x[pixel];
      batch.y[i] = y[pixel];
      batch.z[i] = z[pixel];
    }
    return pixel;
  }

 private:
  static constexpr float kLeastVariance = 1e-8F;  // 0.1 mm: nobody's range is better

  const RangeView& view_;
  VoxelMapCounts& counts_;
  float least_m_, most_m_, most_variance_, position_variance_, attitude_variance_;
};

// Written for the compiler's vectoriser: columns in, columns out, no branch.
void Place(VoteBatch& b, const Window& window, const Eigen::Matrix3f& R, float voxels_per_m) {
  const float cx = window.camera.x(), cy = window.camera.y(), cz = window.camera.z();
  const auto side = static_cast<std::uint32_t>(window.side_blocks);
  for (std::size_t i = 0; i < b.size; ++i) {
    const float dx = R(0, 0) * b.x[i] + R(0, 1) * b.y[i] + R(0, 2) * b.z[i];
    const float dy = R(1, 0) * b.x[i] + R(1, 1) * b.y[i] + R(1, 2) * b.z[i];
    const float dz = R(2, 0) * b.x[i] + R(2, 1) * b.y[i] + R(2, 2) * b.z[i];
    constexpr float kOne = Voxel::kViewOne;
    b.looks[i] = {0,
                  0,
                  0,
                  static_cast<std::int16_t>(-kOne * dx),
                  static_cast<std::int16_t>(-kOne * dy),
                  static_cast<std::int16_t>(-kOne * dz),
                  0,
                  0};
    const float range = b.range_m[i] * voxels_per_m;
    const float px = cx + dx * range, py = cy + dy * range, pz = cz + dz * range;
    const auto ix = static_cast<std::int32_t>(px);
    const auto iy = static_cast<std::int32_t>(py);
    const auto iz = static_cast<std::int32_t>(pz);
    // From the voxel's centre.
    b.x[i] = px - static_cast<float>(ix) - 0.5F;
    b.y[i] = py - static_cast<float>(iy) - 0.5F;
    b.z[i] = pz - static_cast<float>(iz) - 0.5F;
    const auto ux = static_cast<std::uint32_t>(ix), uy = static_cast<std::uint32_t>(iy),
               uz = static_cast<std::uint32_t>(iz);
    b.block[i] = ((uz >> kBlockBits) * side + (uy >> kBlockBits)) * side + (ux >> kBlockBits);
    b.in_block[i] = static_cast<std::uint16_t>(((uz & 7U) << 6) | ((uy & 7U) << 3) | (ux & 7U));
  }
}

void Paint(VoteBatch& b, const ConstImageView& picture) {
  for (std::size_t i = 0; i < b.size; ++i) {
    const std::uint8_t* const rgb = picture.data + std::size_t{b.pixel[i]} * kRgbBytes;
    for (std::size_t c = 0; c < 3; ++c)
      b.looks[i][c] = static_cast<std::int16_t>(rgb[c] * Voxel::kColourOne);
  }
}

// a * b / 65536, lane by lane.
Shorts MulHigh(Shorts a, Shorts b) {
#ifdef __SSE2__
  __m128i x, y;
  std::memcpy(&x, &a, sizeof(x));
  std::memcpy(&y, &b, sizeof(y));
  x = _mm_mulhi_epi16(x, y);  // GCC 12 does not find it in the loop below
  std::memcpy(&a, &x, sizeof(a));
  return a;
#else
  Shorts high;
  for (int k = 0; k < 8; ++k)
    high[k] = static_cast<std::int16_t>((std::int32_t{a[k]} * std::int32_t{b[k]}) >> 16);
  return high;
#endif
}

// A voxel is two registers: sums of floats, and eight int16 of which six are running means.
void Add(VoteBatch& b) {
  constexpr Shorts kMeans{-1, -1, -1, -1, -1, -1, 0, 0};
  constexpr Shorts kOneHit{0, 0, 0, 0, 0, 0, 1, 0};
  for (std::size_t i = 0; i < b.size; ++i) {
    Voxel& v = b.at[i]->voxels[b.slot[i] - 1];
    const float w = b.weight[i];
    const Floats sums =
        LoadVector<Floats>(v.moment.data()) + w * Floats{b.x[i], b.y[i], b.z[i], 1.0F};
    std::memcpy(v.moment.data(), &sums, sizeof(sums));
    if (v.hits == 0xFFFF) HalveCounters(v);
    const std::size_t hits = std::size_t{v.hits} + 1;
    const auto old = LoadVector<Shorts>(v.colour.data());
    const Shorts difference = (LoadVector<Shorts>(b.looks[i].data()) - old) & kMeans;
    const std::int16_t g = kGains[std::min<std::size_t>(hits, Voxel::kMeanVotes)];
    const Shorts gain{g, g, g, g, g, g, 0, 0};
    // The hit is counted in the register as well: a short written on its own would hold up the load
    // of the next vote for the same voxel.
    const Shorts next =
        old + kOneHit + (hits == 1 ? difference : MulHigh(difference + difference, gain));
    std::memcpy(v.colour.data(), &next, sizeof(next));
  }
}

}  // namespace

core::Expected<void> VoxelMap::Vote(const RangeView& view) {
  if (auto fit = CheckView(view); !fit) return fit;
  const Eigen::Vector3d camera_m = view.map_from_camera.translation();
  if (auto back = ReturnAround(camera_m); !back) return back;
  ++pictures_;
  ++counts_.pictures;

  const Window window(camera_m, config_);
  window_.assign(window.size(), nullptr);
  const Eigen::Matrix3f R_map_camera = view.map_from_camera.linear().cast<float>();
  const auto voxels_per_m = static_cast<float>(1.0 / config_.voxel_m);
  const auto block_at = [&](std::uint32_t place) -> VoxelBlock& {
    const int side = window.side_blocks;
    const int n = static_cast<int>(place);
    VoxelBlock& block = grid_.FindOrMake({(window.first.x >> kBlockBits) + n % side,
                                          (window.first.y >> kBlockBits) + n / side % side,
                                          (window.first.z >> kBlockBits) + n / side / side});
    block.revision = pictures_;
    return block;
  };

  Picker picker(view, config_, counts_);
  VoteBatch batch;
  for (std::size_t pixel = 0; pixel < view.rays.pixels();) {
    pixel = picker.Fill(batch, pixel);
    Place(batch, window, R_map_camera, voxels_per_m);
    for (std::size_t i = 0; i < batch.size; ++i) {
      VoxelBlock*& block = window_[batch.block[i]];
      if (block == nullptr) block = &block_at(batch.block[i]);
      batch.at[i] = block;
      __builtin_prefetch(&block->slot[batch.in_block[i]]);
    }
    for (std::size_t i = 0; i < batch.size; ++i) {
      VoxelBlock& block = *batch.at[i];
      batch.slot[i] = grid_.AddVoxel(block, batch.in_block[i]);
      __builtin_prefetch(&block.voxels[batch.slot[i] - 1], 1);
    }
    if (!view.picture.empty()) Paint(batch, view.picture);
    Add(batch);
    counts_.votes += batch.size;
  }
  return {};
}

}  // namespace kawara::vision
