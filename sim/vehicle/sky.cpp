#include "sim/vehicle/sky.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"
#include "sim/dice.hpp"

namespace kawara::sim {
namespace {

constexpr double kFastest_radps = 0.5 * core::kRadFromDeg / 60.0;
constexpr double kWorstDop = 50.0;

/// How the range to a satellite changes with position north, east, down, and the clock.
Eigen::Vector4d RowOf(const SatelliteDirection& s) {
  const double level = std::cos(s.elevation_rad);
  return {-level * std::cos(s.azimuth_rad), -level * std::sin(s.azimuth_rad),
          std::sin(s.elevation_rad), 1.0};
}

}  // namespace

Sky::Sky(int satellites, std::uint64_t seed) {
  Dice dice(seed);
  for (int i = 0; i < satellites; ++i) {
    Satellite s{};
    s.start.azimuth_rad = 2.0 * core::kPi * dice.Uniform();
    s.start.elevation_rad = std::asin(dice.Uniform());
    s.azimuth_rate_radps = kFastest_radps * (2.0 * dice.Uniform() - 1.0);
    s.elevation_rate_radps = kFastest_radps * (2.0 * dice.Uniform() - 1.0);
    satellites_.push_back(s);
  }
}

std::vector<SatelliteDirection> Sky::At(double since_begin_s) const {
  std::vector<SatelliteDirection> now;
  now.reserve(satellites_.size());
  for (const Satellite& s : satellites_) {
    // Up one side and down the other: the number above the horizon stays.
    double elevation =
        std::fmod(s.start.elevation_rad + s.elevation_rate_radps * since_begin_s, core::kPi);
    if (elevation < 0.0) elevation += core::kPi;
    now.push_back({s.start.azimuth_rad + s.azimuth_rate_radps * since_begin_s,
                   std::min(elevation, core::kPi - elevation)});
  }
  return now;
}

std::optional<Geometry> GeometryOf(const std::vector<SatelliteDirection>& used) {
  if (used.size() < 4) return std::nullopt;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (const SatelliteDirection& s : used) normal += RowOf(s) * RowOf(s).transpose();
  Geometry g;
  bool invertible = false;
  normal.computeInverseWithCheck(g.cofactor, invertible, 1e-9);
  if (!invertible) return std::nullopt;
  g.axis_dop = g.cofactor.diagonal().head<3>().cwiseMax(0.0).cwiseSqrt();
  g.hdop = g.axis_dop.head<2>().norm();
  g.vdop = g.axis_dop.z();
  if (!(g.hdop < kWorstDop && g.vdop < kWorstDop)) return std::nullopt;
  return g;
}

Eigen::Vector3d PositionErrorOf(const Geometry& geometry,
                                const std::vector<SatelliteDirection>& used,
                                const std::vector<double>& range_errors_m) {
  Eigen::Vector4d right_side = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < used.size(); ++i) right_side += RowOf(used[i]) * range_errors_m[i];
  return (geometry.cofactor * right_side).head<3>();
}

}  // namespace kawara::sim
