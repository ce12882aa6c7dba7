#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/dice.hpp"
#include "sim/vehicle/sensor_config.hpp"
#include "sim/vehicle/trajectory.hpp"

namespace kawara::sim {

/// Iron that bends the compass: a magnetic dipole standing at the site.
struct SteelObject {
  Eigen::Vector3d position_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_enu_am2 = Eigen::Vector3d::Zero();  ///< a car: some 100 A m^2, downwards
};

/// Field [gauss] of the steel objects at a point. Nearer than half a metre a dipole is no model of
/// a thing with a size: the field of that distance.
Eigen::Vector3d SteelFieldEnu(const std::vector<SteelObject>& steel,
                              const Eigen::Vector3d& point_enu_m);

/// A three-axis magnetometer at a lever arm of a vehicle of steel:
///   field = (I + soft iron) (Earth's and steel objects' field in the body) + hard iron + noise.
/// The Earth's field is that of the site, uniform in its ENU axes. One thread.
class Magnetometer {
 public:
  /// `steel` must outlive it.
  Magnetometer(const MagnetometerConfig& config, const std::vector<SteelObject>& steel,
               std::uint64_t seed);
  /// [gauss], body axes.
  Eigen::Vector3d Measure(const MotionState& state, const Eigen::Vector3d& lever_frd_m);

 private:
  const std::vector<SteelObject>& steel_;
  Dice dice_;
  Eigen::Vector3d earth_enu_gauss_;
  Eigen::Vector3d hard_iron_gauss_;
  Eigen::Matrix3d soft_iron_;
  double noise_gauss_;
};

}  // namespace kawara::sim
