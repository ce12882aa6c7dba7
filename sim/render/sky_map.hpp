#pragma once
#include <Eigen/Core>
#include <vector>

#include "sim/site/scene.hpp"

namespace kawara::sim {

/// What a ray sees that meets nothing: a clear to overcast sky after Scene's sun (Sun::sky_share
/// near 1: overcast), clouds, the glow round the sun, and far below it a hazy skyline of hills and
/// roofs, which has no range. Drawn once by rule from a seed; looked up afterwards.
///
/// Radiance in units in which a white level surface under sun and sky is 1; the sky alone lights it
/// with Sun::sky_share. Immutable; any thread.
class SkyMap {
 public:
  /// `columns`: texels round the horizon, 64 and more.
  SkyMap(const Sun& sun, std::uint32_t seed, int columns = 2048);

  /// `direction_enu` of unit length; the sun's disk is not in it.
  Eigen::Array3f Radiance(const Eigen::Vector3f& direction_enu) const;
  /// Light of the sun on a surface square to it; black when it is overcast or below the horizon.
  const Eigen::Array3f& sun_rgb() const { return sun_rgb_; }
  const Eigen::Vector3f& to_sun_enu() const { return to_sun_; }
  /// What far things fade into.
  const Eigen::Array3f& haze_rgb() const { return haze_rgb_; }

 private:
  struct Skyline;
  Skyline SkylineAt(float azimuth_rad) const;
  Eigen::Array3f DrawColumn(int column);
  Eigen::Array3f DrawSky(const Eigen::Vector3f& direction) const;
  Eigen::Array3f DrawLand(const Eigen::Array3f& sky, const Skyline& line, float azimuth_rad,
                          float elevation_rad) const;

  std::size_t Texel(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  Sun sun_;
  std::uint32_t seed_;
  int columns_, rows_;
  float texels_per_rad_;
  float overcast_;
  Eigen::Vector3f to_sun_;
  Eigen::Array3f sun_rgb_, haze_rgb_;
  std::vector<Eigen::Array3f> texels_;  ///< rows from the zenith down, columns clockwise from north
};

}  // namespace kawara::sim
