#include "sim/vehicle/magnetometer.hpp"

#include <algorithm>
#include <cmath>

#include "sim/vehicle/random_processes.hpp"

namespace kawara::sim {
namespace {

constexpr double kNearest_m = 0.5;
constexpr double kMuOver4Pi_gauss = 1e-7 * 1e4;  ///< T m/A, and gauss a tesla

}  // namespace

Eigen::Vector3d SteelFieldEnu(const std::vector<SteelObject>& steel,
                              const Eigen::Vector3d& point_enu_m) {
  Eigen::Vector3d field = Eigen::Vector3d::Zero();
  for (const SteelObject& object : steel) {
    const Eigen::Vector3d way = point_enu_m - object.position_enu_m;
    const double distance = way.norm();
    const Eigen::Vector3d out =
        distance > 1e-9 ? (way / distance).eval() : Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d& moment = object.moment_enu_am2;
    field += kMuOver4Pi_gauss * (3.0 * moment.dot(out) * out - moment) /
             std::pow(std::max(distance, kNearest_m), 3);
  }
  return field;
}

Magnetometer::Magnetometer(const MagnetometerConfig& config, const std::vector<SteelObject>& steel,
                           std::uint64_t seed)
    : steel_(steel), dice_(seed), noise_gauss_(config.noise_gauss) {
  const double declination = config.declination_deg * core::kRadFromDeg;
  const double dip = config.dip_deg * core::kRadFromDeg;
  const double level = config.field_gauss * std::cos(dip);
  earth_enu_gauss_ = {level * std::sin(declination), level * std::cos(declination),
                      -config.field_gauss * std::sin(dip)};
  hard_iron_gauss_ = config.hard_iron_gauss * DrawnVector(dice_);
  soft_iron_.setIdentity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      soft_iron_(row, column) += config.soft_iron * DrawnNormal(dice_);
  }
}

Eigen::Vector3d Magnetometer::Measure(const MotionState& state,
                                      const Eigen::Vector3d& lever_frd_m) {
  const Eigen::Vector3d field =
      earth_enu_gauss_ + SteelFieldEnu(steel_, state.PointEnu(lever_frd_m));
  return soft_iron_ * (state.R_enu_body.transpose() * field) + hard_iron_gauss_ +
         noise_gauss_ * NormalVector(dice_);
}

}  // namespace kawara::sim
