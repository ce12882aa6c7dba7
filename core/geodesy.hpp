#pragma once
#include <Eigen/Core>
#include <memory>

namespace GeographicLib {
class LocalCartesian;
}

namespace kawara::core {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadFromDeg = kPi / 180.0;
constexpr double kDegFromRad = 180.0 / kPi;

/// WGS 84 geodetic position; height above the ellipsoid.
struct Geodetic {
  double lat_rad = 0.0;
  double lon_rad = 0.0;
  double h_ellipsoidal_m = 0.0;
};

Eigen::Vector3d EcefFromGeodetic(const Geodetic& g);
Geodetic GeodeticFromEcef(const Eigen::Vector3d& ecef_m);

/// Tangent plane east, north, up [m] at an origin (GeographicLib::LocalCartesian). Immutable; any
/// thread.
class LocalEnu {
 public:
  explicit LocalEnu(const Geodetic& origin);
  const Geodetic& origin() const { return origin_; }
  Eigen::Vector3d FromGeodetic(const Geodetic& g) const;
  Geodetic ToGeodetic(const Eigen::Vector3d& enu_m) const;

 private:
  Geodetic origin_;
  std::shared_ptr<const GeographicLib::LocalCartesian> plane_;
};

/// The point north/east/down [m] of g (in the tangent plane at g; so 100 m on it is 0.8 mm above
/// the ellipsoid). Good to a nanometre or so at any place and distance, poles included. Real-time
/// safe.
Geodetic OffsetNed(const Geodetic& g, const Eigen::Vector3d& ned_m);
/// North, east, down [m] from `from` to `to` in the tangent plane at `from`: the inverse of
/// OffsetNed. Real-time safe.
Eigen::Vector3d NedBetween(const Geodetic& from, const Geodetic& to);

/// Roll, pitch, yaw [rad], ZYX from north-east-down to forward-right-down: T_ned_body = Rz(yaw)
/// Ry(pitch) Rx(roll).
struct Attitude {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double yaw_rad = 0.0;
};
Eigen::Matrix3d RotationNedFromBody(const Attitude& a);
/// Takes north, east, down at `place` to the east, north, up of the tangent plane at `origin`.
Eigen::Matrix3d RotationEnuFromNed(const Geodetic& origin, const Geodetic& place);
/// Inverse of RotationNedFromBody; pitch in [-pi/2, pi/2], roll and yaw in (-pi, pi]. Looking
/// straight up or down, roll is 0.
Attitude AttitudeFromRotation(const Eigen::Matrix3d& R_ned_body);
/// Into (-pi, pi].
double WrapPi(double angle_rad);

}  // namespace kawara::core
