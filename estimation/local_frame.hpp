#pragma once
#include <Eigen/Core>

#include "core/geodesy.hpp"

/// Changes of axes that the pose composer needs.
namespace kawara::estimation {

inline Eigen::Matrix3d EnuFromNed() {
  return (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
}
inline Eigen::Vector3d EnuFromNed(const Eigen::Vector3d& ned) {
  return {ned.y(), ned.x(), -ned.z()};
}
inline Eigen::Vector3d NedFromEnu(const Eigen::Vector3d& enu) {
  return {enu.y(), enu.x(), -enu.z()};
}

/// CrossMatrix(a) * b = a x b.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  return (Eigen::Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

/// East, north, up [m] from `from` to `to` in the tangent plane at `from`.
inline Eigen::Vector3d EnuBetween(const core::Geodetic& from, const core::Geodetic& to) {
  return EnuFromNed(core::NedBetween(from, to));
}

}  // namespace kawara::estimation
