#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {
namespace {

/// Looks voxels up in one distance image.
class Looker {
 public:
  Looker(const RangeView& view, const VoxelMapConfig& config)
      : view_(view),
        voxel_m_(static_cast<float>(config.voxel_m)),
        half_diagonal_m_(static_cast<float>(0.5 * std::sqrt(3.0) * config.voxel_m)),
        sigmas_(static_cast<float>(config.see_through_sigmas)),
        position_variance_(static_cast<float>(view.position_sd_m * view.position_sd_m)),
        attitude_variance_(static_cast<float>(view.attitude_sd_rad * view.attitude_sd_rad)),
        width_(view.ranges.width_px),
        height_(view.ranges.height_px) {}

  void Prefetch(std::int32_t pixel) const {
    if (pixel == CameraRays::kNoPixel) return;
    __builtin_prefetch(view_.ranges.range_m.data() + pixel);
    __builtin_prefetch(view_.ranges.sd_m.data() + pixel);
  }

  /// Rays that went through the voxel whose centroid `pixel` looks at, `distance_m` away; 0: none,
  /// or nobody knows.
  int RaysThrough(std::int32_t pixel, float distance_m) const {
    if (pixel == CameraRays::kNoPixel || !IsBehind(pixel, distance_m)) return 0;
    // At an edge the voxel may belong to the nearer pixel beside: all known neighbours must agree.
    const int u = pixel % width_, v = pixel / width_;
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        const int uu = u + du, vv = v + dv;
        if (uu < 0 || vv < 0 || uu >= width_ || vv >= height_) continue;
        const std::int32_t beside = vv * width_ + uu;
        if (!std::isnan(view_.ranges.range_m[static_cast<std::size_t>(beside)]) &&
            !IsBehind(beside, distance_m))
          return 0;
      }
    }
    const float side_rad = voxel_m_ / distance_m;
    const float rays = side_rad * side_rad * view_.rays.PixelsPerSteradian(pixel);
    return std::clamp(static_cast<int>(rays), 1, 0x7FFF);
  }

 private:
  /// NaN anywhere: no.
  bool IsBehind(std::int32_t pixel, float distance_m) const {
    const auto i = static_cast<std::size_t>(pixel);
    const float excess_m = view_.ranges.range_m[i] - distance_m - half_diagonal_m_;
    if (!(excess_m > 0.0F)) return false;
    const float sd = view_.ranges.sd_m[i];
    const float variance =
        sd * sd + position_variance_ + attitude_variance_ * distance_m * distance_m;
    return excess_m * excess_m > sigmas_ * sigmas_ * variance;
  }

  const RangeView& view_;
  float voxel_m_, half_diagonal_m_, sigmas_, position_variance_, attitude_variance_;
  int width_, height_;
};

/// Voxels of one block on their way through Examine.
struct Asked {
  Voxel* voxel;
  float distance_m;
  std::int32_t pixel;
  std::size_t texel;
};

void Prefetch(const VoxelBlock& block) {
  constexpr std::size_t kLine = 64 / sizeof(Voxel);
  for (std::size_t i = 0; i < block.count; i += kLine)
    __builtin_prefetch(block.voxels + i, 1);  // to be written
}

void CountThrough(Voxel& v, int rays) {
  constexpr int kMost = 0xFFFF;
  while (v.see_through + rays > kMost) {
    v.hits = std::max<std::uint16_t>(1, v.hits / 2);
    v.see_through /= 2;
    rays = std::min(rays, kMost / 2);
  }
  v.see_through = static_cast<std::uint16_t>(v.see_through + rays);
}

}  // namespace

core::Expected<void> VoxelMap::Examine(const RangeView& view) {
  if (auto fit = CheckView(view); !fit) return fit;
  const Eigen::Vector3d camera_m = view.map_from_camera.translation();
  if (auto back = ReturnAround(camera_m); !back) return back;

  const Looker looker(view, config_);
  const auto voxel_m = static_cast<float>(config_.voxel_m);
  const Eigen::Matrix3f R_camera_map = view.map_from_camera.linear().transpose().cast<float>();
  const auto reach_m = static_cast<float>(config_.max_range_m);
  const auto nearest_m = static_cast<float>(config_.voxel_m);
  const float block_m = voxel_m * kBlockSide;
  std::array<Asked, kBlockVoxels> all;
  for (const auto& [tile, blocks] : grid_.tiles()) {
    if (HorizontalDistance(tile, camera_m) > config_.max_range_m) continue;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      VoxelBlock* const block = blocks[b];
      const Eigen::Vector3f corner_m =
          (Eigen::Vector3d(block->index.x, block->index.y, block->index.z) *
               (config_.voxel_m * kBlockSide) -
           camera_m)
              .cast<float>();
      const Eigen::Vector3f nearest = Eigen::Vector3f::Zero().cwiseMax(corner_m).cwiseMin(
          Eigen::Vector3f(corner_m.array() + block_m));
      if (nearest.squaredNorm() > reach_m * reach_m) continue;
      // In three passes, each asking the memory for what the next one needs: the tables are larger
      // than caches, and one after the other most of the time would be waiting.
      std::size_t asked = 0;
      block->ForEach([&](std::size_t i, Voxel& v) {
        const float scale = 1.0F / v.weight;
        const Eigen::Vector3f in_block(
            static_cast<float>(i & 7U) + 0.5F + v.moment[0] * scale,
            static_cast<float>((i >> 3) & 7U) + 0.5F + v.moment[1] * scale,
            static_cast<float>(i >> 6) + 0.5F + v.moment[2] * scale);
        const Eigen::Vector3f from_camera_m = corner_m + in_block * voxel_m;
        const float distance_m = from_camera_m.norm();
        if (distance_m > reach_m || distance_m < nearest_m) return;
        const std::size_t texel = view.rays.TexelOf(R_camera_map * from_camera_m);
        view.rays.Prefetch(texel);
        all[asked++] = {&v, distance_m, CameraRays::kNoPixel, texel};
      });
      if (b + 1 < blocks.size()) Prefetch(*blocks[b + 1]);
      const std::span<Asked> these(all.data(), asked);
      for (Asked& a : these) {
        a.pixel = view.rays.PixelAt(a.texel);
        looker.Prefetch(a.pixel);
      }
      bool changed = false;
      for (const Asked& a : these) {
        const int rays = looker.RaysThrough(a.pixel, a.distance_m);
        if (rays == 0) continue;
        CountThrough(*a.voxel, rays);
        changed = true;
        ++counts_.seen_through;
      }
      if (changed) block->revision = pictures_;
    }
  }
  return {};
}

}  // namespace kawara::vision
