#include "sim/render/sky_map.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"
#include "sim/render/noise2.hpp"

namespace kawara::sim {
namespace {

constexpr float kPi = static_cast<float>(core::kPi);
/// From the zenith to 20 degrees below the horizon, as many rows a radian as columns.
constexpr float kLowest_rad = -0.35F;
/// No hill or roof of the skyline is higher.
constexpr float kHighestLand_rad = 0.14F;

Eigen::Array3f Blend(const Eigen::Array3f& a, const Eigen::Array3f& b, float share_of_b) {
  return a + (b - a) * share_of_b;
}

}  // namespace

/// Height of the land's edge at a direction of the compass: hills far away, roofs before them.
struct SkyMap::Skyline {
  float hills_rad;
  float roofs_rad;
  std::uint32_t roof;  ///< which house; 0: trees
};

SkyMap::Skyline SkyMap::SkylineAt(float azimuth_rad) const {
  const float x = 4.0F * std::cos(azimuth_rad);
  const float y = 4.0F * std::sin(azimuth_rad);
  Skyline s{};
  s.hills_rad = std::clamp(0.030F + 0.045F * Fractal2(x, y, 2.2F, 6, 0.5F, 0.0F, seed_ + 11U), 0.0F,
                           kHighestLand_rad);
  // Houses of 10 to 40 m across at 300 m; some under a gable, some flat, trees between them.
  const float place = azimuth_rad / (2.0F * kPi) * 96.0F;
  const std::int32_t number = FloorInt(place);
  s.roof = HashCell(number, 7, seed_ + 13U);
  const float within = place - static_cast<float>(number);
  const float margin = 0.25F * UnitFromHash(s.roof * 0x9E3779B1U);
  const bool gable = (s.roof & 3U) == 0;
  const float height =
      (0.008F + 0.022F * UnitFromHash(s.roof) * UnitFromHash(s.roof * 0x85EBCA77U)) *
      (gable ? 1.0F - 0.5F * std::abs(2.0F * within - 1.0F) : 1.0F);
  const float trees =
      0.009F + 0.007F * Fractal2(12.0F * x, 12.0F * y, 1.0F, 4, 0.6F, 0.0F, seed_ + 17U);
  const bool built = within > margin && within < 1.0F - margin && height > trees;
  s.roofs_rad = built ? height : trees;
  if (!built) s.roof = 0;
  return s;
}

SkyMap::SkyMap(const Sun& sun, std::uint32_t seed, int columns)
    : sun_(sun),
      seed_(seed),
      columns_(std::max(columns, 64)),
      texels_per_rad_(static_cast<float>(columns_) / (2.0F * kPi)),
      overcast_(SmoothStep(0.45F, 0.95F, static_cast<float>(sun.sky_share))) {
  const double c = std::cos(sun.elevation_rad);
  to_sun_ = Eigen::Vector3d(std::sin(sun.azimuth_rad) * c, std::cos(sun.azimuth_rad) * c,
                            std::sin(sun.elevation_rad))
                .cast<float>();
  const auto share = static_cast<float>(std::clamp(sun.sky_share, 0.02, 1.0));
  // The lower, the redder; through much air also the weaker (the share says how much is left).
  const float low = 1.0F - SmoothStep(0.05F, 0.7F, static_cast<float>(sun.elevation_rad));
  const Eigen::Array3f tint = Blend({1.04F, 1.0F, 0.93F}, {1.35F, 0.98F, 0.60F}, low);
  const float height = std::max(to_sun_.z(), 0.0F);
  sun_rgb_ = Eigen::Array3f::Zero();
  if (height > 0.01F) sun_rgb_ = tint * ((1.0F - share) / std::max(height, 0.12F));

  rows_ = static_cast<int>(std::ceil((kPi / 2 - kLowest_rad) * texels_per_rad_));
  texels_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  std::vector<Eigen::Array3f> level_light(static_cast<std::size_t>(columns_));
  tbb::parallel_for(0, columns_, [&](int column) {
    level_light[static_cast<std::size_t>(column)] = DrawColumn(column);
  });
  // Light on a level surface, over pi: the integral of radiance times cosine.
  double sum = 0.0;
  for (const Eigen::Array3f& light : level_light) sum += static_cast<double>(light.mean());
  const double mean = sum / std::pow(static_cast<double>(texels_per_rad_), 2.0) / core::kPi;
  for (Eigen::Array3f& texel : texels_)
    texel *= static_cast<float>(static_cast<double>(share) / mean);
  haze_rgb_ = Eigen::Array3f::Zero();
  const int above_land = static_cast<int>((kPi / 2 - kHighestLand_rad) * texels_per_rad_);
  for (int column = 0; column < columns_; ++column) {
    haze_rgb_ += texels_[Texel(column, above_land)];
  }
  haze_rgb_ /= static_cast<float>(columns_);
}

// Returns the column's share of the light on a level surface, before scaling.
Eigen::Array3f SkyMap::DrawColumn(int column) {
  const float azimuth = (static_cast<float>(column) + 0.5F) / texels_per_rad_;
  const Skyline line = SkylineAt(azimuth);
  Eigen::Array3f level_light = Eigen::Array3f::Zero();
  for (int row = 0; row < rows_; ++row) {
    const float elevation = kPi / 2 - (static_cast<float>(row) + 0.5F) / texels_per_rad_;
    const float across = std::cos(elevation);
    const Eigen::Vector3f d(std::sin(azimuth) * across, std::cos(azimuth) * across,
                            std::sin(elevation));
    Eigen::Array3f radiance = DrawSky(d);
    if (elevation < kHighestLand_rad) radiance = DrawLand(radiance, line, azimuth, elevation);
    texels_[Texel(column, row)] = radiance;
    if (elevation > 0.0F) level_light += radiance * (d.z() * across);
  }
  return level_light;
}

Eigen::Array3f SkyMap::DrawSky(const Eigen::Vector3f& d) const {
  const float up = std::max(d.z(), 0.0F);
  // Clear: deep blue above, pale at the horizon. Overcast: three times as bright above as below.
  const float pale = std::exp(-up / 0.20F);
  Eigen::Array3f clear = Blend({0.38F, 0.59F, 0.98F}, {1.05F, 1.22F, 1.38F}, 0.12F + 0.88F * pale);
  const float glow = std::max(d.dot(to_sun_), 0.0F);
  clear += Eigen::Array3f(1.0F, 0.93F, 0.80F) *
           (0.35F * std::pow(glow, 8.0F) + 1.6F * std::pow(glow, 90.0F));
  const Eigen::Array3f grey = Eigen::Array3f(0.97F, 1.0F, 1.04F) * (0.45F + 0.75F * up);
  Eigen::Array3f sky = Blend(clear, grey, overcast_);
  if (d.z() <= 0.0F) return sky;

  // Clouds on a plane above, drawn together towards the horizon.
  const float reach = 1.0F / (d.z() + 0.08F);
  const float x = d.x() * reach;
  const float y = d.y() * reach;
  const float footprint = 0.006F * reach * reach;
  const float bend_x = Fractal2(x, y, 1.6F, 3, 0.5F, footprint, seed_ + 1U);
  const float bend_y = Fractal2(x, y, 1.6F, 3, 0.5F, footprint, seed_ + 2U);
  const float cloud =
      Fractal2(x + 0.5F * bend_x, y + 0.5F * bend_y, 2.2F, 7, 0.55F, footprint, seed_ + 3U);
  const float cover = SmoothStep(0.05F - 0.5F * overcast_, 0.95F - 0.3F * overcast_, cloud) *
                      SmoothStep(0.0F, 0.10F, d.z());
  const float lit =
      Mix(1.75F, 1.05F, SmoothStep(0.3F, 1.3F, cloud)) * (1.0F + 0.5F * std::pow(glow, 6.0F));
  const Eigen::Array3f white = Eigen::Array3f(1.0F, 0.99F, 0.98F) * Mix(lit, 0.85F, overcast_);
  return Blend(sky, white, (0.80F - 0.35F * overcast_) * cover);
}

Eigen::Array3f SkyMap::DrawLand(const Eigen::Array3f& sky, const Skyline& line, float azimuth,
                                float elevation) const {
  const Eigen::Array3f haze = Blend({0.95F, 1.06F, 1.18F}, {0.55F, 0.56F, 0.58F}, overcast_);
  const float texel = 1.0F / texels_per_rad_;
  const float texture =
      Fractal2(60.0F * azimuth, 60.0F * elevation, 1.0F, 3, 0.6F, 0.0F, seed_ + 19U);
  const auto below = [&](float edge_rad) {
    return 1.0F - SmoothStep(edge_rad - texel, edge_rad + texel, elevation);
  };
  const Eigen::Array3f hills = Eigen::Array3f(0.30F, 0.40F, 0.40F) * (1.0F + 0.1F * texture);
  Eigen::Array3f seen = Blend(sky, Blend(haze, hills, 0.45F), below(line.hills_rad));
  Eigen::Array3f near = Eigen::Array3f(0.16F, 0.22F, 0.13F) * (1.0F + 0.35F * texture);
  if (line.roof != 0) {
    const float tone = 0.20F + 0.45F * UnitFromHash(line.roof * 0xC2B2AE3DU);
    near = Eigen::Array3f(tone, 0.97F * tone, 0.93F * tone);
  }
  seen = Blend(seen, Blend(haze, near, 0.62F), below(line.roofs_rad));
  // Below everything: land in haze, nearer and darker the lower one looks.
  const Eigen::Array3f land = Eigen::Array3f(0.30F, 0.31F, 0.25F) * (1.0F + 0.10F * texture);
  const float nearness = SmoothStep(0.0F, 0.10F, -elevation);
  return Blend(seen, Blend(haze, land, 0.55F + 0.4F * nearness), below(0.0F));
}

Eigen::Array3f SkyMap::Radiance(const Eigen::Vector3f& d) const {
  const float elevation = std::asin(std::clamp(d.z(), -1.0F, 1.0F));
  float azimuth = std::atan2(d.x(), d.y());
  if (azimuth < 0.0F) azimuth += 2.0F * kPi;
  const float x = azimuth * texels_per_rad_ - 0.5F;
  const float y = std::clamp((kPi / 2 - elevation) * texels_per_rad_ - 0.5F, 0.0F,
                             static_cast<float>(rows_ - 1));
  const std::int32_t i = FloorInt(x);
  const std::int32_t j = std::min(FloorInt(y), rows_ - 2);
  const float fx = x - static_cast<float>(i);
  const float fy = y - static_cast<float>(j);
  const auto texel = [&](std::int32_t column, std::int32_t row) -> const Eigen::Array3f& {
    const std::int32_t round = column < 0           ? column + columns_
                               : column >= columns_ ? column - columns_
                                                    : column;
    return texels_[Texel(round, row)];
  };
  return (texel(i, j) * (1.0F - fx) + texel(i + 1, j) * fx) * (1.0F - fy) +
         (texel(i, j + 1) * (1.0F - fx) + texel(i + 1, j + 1) * fx) * fy;
}

}  // namespace kawara::sim
