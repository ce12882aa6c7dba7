#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace kawara::sim {

struct SatelliteDirection {
  double azimuth_rad = 0.0;  ///< true, clockwise from north
  double elevation_rad = 0.0;
};

/// Satellites above a site: directions spread evenly over the half sphere by the seed, each
/// wandering across it by up to half a degree a minute. No orbits: their numbers and geometry are
/// what counts here. Immutable; any thread.
class Sky {
 public:
  Sky(int satellites, std::uint64_t seed);
  std::vector<SatelliteDirection> At(double since_begin_s) const;

 private:
  struct Satellite {
    SatelliteDirection start;
    double azimuth_rate_radps, elevation_rate_radps;
  };
  std::vector<Satellite> satellites_;
};

/// How a set of directions turns range errors into errors of position.
struct Geometry {
  /// Inverse of the normal equations, north, east, down, clock.
  Eigen::Matrix4d cofactor = Eigen::Matrix4d::Zero();
  Eigen::Vector3d axis_dop = Eigen::Vector3d::Zero();  ///< north, east, down
  double hdop = 0.0;
  double vdop = 0.0;
};
/// Nothing for fewer than four satellites or a hopeless geometry.
std::optional<Geometry> GeometryOf(const std::vector<SatelliteDirection>& used);
/// Position error north, east, down [m] that range errors [m] of these satellites cause.
Eigen::Vector3d PositionErrorOf(const Geometry& geometry,
                                const std::vector<SatelliteDirection>& used,
                                const std::vector<double>& range_errors_m);

}  // namespace kawara::sim
