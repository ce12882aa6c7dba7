#include "sim/render/lens.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.hpp"
#include "sim/dice.hpp"
#include "sim/render/noise2.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::sim {
namespace {

constexpr int kTilePx = 32;
constexpr int kBlockPx = 4;

/// 0 in the middle of the picture (for a ring: where it is brightest), 1 at its rim.
class RimDistance {
 public:
  explicit RimDistance(const vision::CameraModel& camera)
      : ring_(dynamic_cast<const vision::DoughnutCamera*>(&camera)),
        stitched_(dynamic_cast<const vision::EquirectangularCamera*>(&camera) != nullptr),
        center_(0.5 * (camera.width_px() - 1), 0.5 * (camera.height_px() - 1)),
        corner_px_(std::hypot(camera.width_px(), camera.height_px()) / 2) {}

  double At(int u, int v) const {
    if (stitched_) return 0.0;  // made of many pictures, each flattened before
    if (ring_ == nullptr) return (Eigen::Vector2d(u, v) - center_).norm() / corner_px_;
    const vision::DoughnutParameters& p = ring_->parameters();
    const double r = std::hypot(u - p.center_u_px, (v - p.center_v_px) / p.v_scale);
    const double middle = 0.6 * p.l_out_px + 0.4 * p.l_in_px;
    return r > middle ? (r - middle) / (p.l_out_px - middle) : (middle - r) / (middle - p.l_in_px);
  }

 private:
  const vision::DoughnutCamera* ring_;
  bool stitched_;
  Eigen::Vector2d center_;
  double corner_px_;
};

// The camera's own front, mirrored in the middle of the ring: a dark lens in a paler ring, and a
// faint glow in the corners from light that went round the mirror.
float SurroundAt(const vision::CameraModel& camera, const LensSettings& lens, int u, int v) {
  const auto* ring = dynamic_cast<const vision::DoughnutCamera*>(&camera);
  if (ring == nullptr) return 0.0F;
  const vision::DoughnutParameters& p = ring->parameters();
  const double r = std::hypot(u - p.center_u_px, (v - p.center_v_px) / p.v_scale);
  double value = 0.0;
  if (r < p.l_in_px) {
    const double share = r / p.l_in_px;
    const auto rim = [&](double at, double width) {
      return std::exp(-(share - at) * (share - at) / (width * width));
    };
    value = 0.25 + 0.8 * rim(0.62, 0.05) + 0.35 * rim(0.38, 0.12) + 0.5 * rim(1.0, 0.04) -
            0.2 * rim(0.0, 0.25);
    value *= 0.85 + 0.15 * std::sin(3.0 * std::atan2(v - p.center_v_px, u - p.center_u_px));
  } else {
    value = 0.35 * std::exp(-(r - p.l_out_px) / (0.04 * p.l_out_px)) + 0.05;
  }
  return static_cast<float>(lens.surround * std::max(value, 0.0));
}

/// No pixel is smaller than this, nor are its sides parallel.
constexpr float kLeastPixel_rad = 1e-6F;

PixelTangents TangentsOf(const vision::CameraModel& camera, const PixelRay& ray) {
  PixelTangents tangents;
  for (const bool along_u : {true, false}) {
    const Eigen::Vector2d half(along_u ? 0.5 : 0.0, along_u ? 0.0 : 0.5);
    const Eigen::Vector2d middle(ray.u, ray.v);
    const auto before = camera.Unproject(middle - half);
    const auto after = camera.Unproject(middle + half);
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    if (before && after) {
      change = *after - *before;
    } else if (before) {
      change = 2.0 * (ray.direction_camera - *before);
    } else if (after) {
      change = 2.0 * (*after - ray.direction_camera);
    }
    (along_u ? tangents.along_u : tangents.along_v) = change.cast<float>();
  }
  return tangents;
}

// Pure functions of each ray, on all cores.
void FindTangents(const vision::CameraModel& camera, RayTable& table) {
  table.tangents.resize(table.rays.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, table.rays.size(), 4096),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        PixelRay& ray = table.rays[i];
                        const PixelTangents& t = table.tangents[i] = TangentsOf(camera, ray);
                        ray.pixel_rad = std::sqrt(std::max(t.along_u.norm(), kLeastPixel_rad) *
                                                  std::max(t.along_v.norm(), kLeastPixel_rad));
                      }
                    });
}

void AddDirt(const vision::CameraModel& camera, const LensSettings& lens, RayTable& table) {
  if (table.rays.empty()) return;
  Dice dice(lens.seed);
  for (int spot = 0; spot < lens.dirt_spots; ++spot) {
    const PixelRay& center = table.rays[static_cast<std::size_t>(dice.Next() % table.rays.size())];
    const double radius_px = camera.width_px() * lens.dirt_size * (0.25 + 0.75 * dice.Uniform());
    const auto dim = static_cast<float>(0.15 + 0.30 * dice.Uniform());
    const auto salt = static_cast<std::uint32_t>(dice.Next());
    const int reach = static_cast<int>(std::ceil(1.6 * radius_px));
    const int cu = center.u;
    const int cv = center.v;
    for (int v = std::max(0, cv - reach); v <= std::min(camera.height_px() - 1, cv + reach); ++v) {
      for (int u = std::max(0, cu - reach); u <= std::min(camera.width_px() - 1, cu + reach); ++u) {
        const std::int32_t at = table.RayAt(u, v);
        if (at < 0) continue;
        const auto x = static_cast<float>((u - cu) / radius_px);
        const auto y = static_cast<float>((v - cv) / radius_px);
        const float r = std::hypot(x, y) + 0.25F * Noise2(1.5F * x, 1.5F * y, salt);
        const float share = dim * (1.0F - SmoothStep(0.5F, 1.3F, r));
        PixelRay& ray = table.rays[static_cast<std::size_t>(at)];
        ray.through *= 1.0F - share;
        ray.veil += 0.45F * share;
      }
    }
  }
}

}  // namespace

RayTable RayTable::Build(const vision::CameraModel& camera, const LensSettings& lens) {
  const int width = camera.width_px();
  const int height = camera.height_px();
  CORE_CHECK(width > 0 && height > 0 && width <= 65535 && height <= 65535);
  RayTable table;
  table.width_px = width;
  table.ray_at.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), -1);
  const RimDistance rim(camera);
  const auto add = [&](int u, int v) {
    const std::size_t index =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
    const auto direction = camera.Unproject({static_cast<double>(u), static_cast<double>(v)});
    if (!direction) {
      table.surround.push_back({static_cast<std::uint32_t>(index), SurroundAt(camera, lens, u, v)});
      return;
    }
    PixelRay ray;
    ray.direction_camera = direction->normalized();
    const double from_middle = rim.At(u, v);
    ray.through =
        static_cast<float>(1.0 - lens.vignetting * from_middle * from_middle * from_middle);
    ray.u = static_cast<std::uint16_t>(u);
    ray.v = static_cast<std::uint16_t>(v);
    table.ray_at[index] = static_cast<std::int32_t>(table.rays.size());
    table.rays.push_back(ray);
  };
  for (int tile_v = 0; tile_v < height; tile_v += kTilePx) {
    for (int tile_u = 0; tile_u < width; tile_u += kTilePx) {
      for (int block = 0; block < (kTilePx / kBlockPx) * (kTilePx / kBlockPx); ++block) {
        const int block_u = tile_u + block % (kTilePx / kBlockPx) * kBlockPx;
        const int block_v = tile_v + block / (kTilePx / kBlockPx) * kBlockPx;
        for (int v = block_v; v < std::min(block_v + kBlockPx, height); ++v) {
          for (int u = block_u; u < std::min(block_u + kBlockPx, width); ++u) add(u, v);
        }
      }
    }
  }
  FindTangents(camera, table);
  AddDirt(camera, lens, table);
  return table;
}

}  // namespace kawara::sim
