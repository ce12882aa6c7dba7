#pragma once
#include <Eigen/Core>

#include "sim/vehicle/trajectory.hpp"

namespace kawara::sim {

/// What faultless gyros and accelerometers of the body's axes feel.
struct Inertial {
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();           ///< against the stars
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();  ///< at rest level: z about -9.8
};

/// At one instant, at a lever arm of the body. The site's ENU axes turn with the Earth, so that the
/// force is acceleration plus Coriolis less gravity (the centrifugal force is part of normal
/// gravity), without approximation.
Inertial InertialAt(const Trajectory& trajectory, const Eigen::Vector3d& lever_frd_m,
                    double since_begin_s);

/// Mean over an interval: what a sensor delivers that integrates between samples (delta angle and
/// delta velocity, divided by the interval). Gauss-Legendre with four points.
Inertial MeanInertial(const Trajectory& trajectory, const Eigen::Vector3d& lever_frd_m,
                      double from_s, double to_s);

}  // namespace kawara::sim
