#include "estimation/strapdown.hpp"

#include "estimation/earth.hpp"
#include "estimation/rotation.hpp"

namespace kawara::estimation {

void Strapdown(NominalState& state, const ImuInterval& imu, double dt_s, bool hold_attitude) {
  const double lat = state.position.lat_rad;
  const double height = state.position.h_ellipsoidal_m;
  const Eigen::Vector3d rate = state.TrueRate(imu.rate_radps);
  const Eigen::Vector3d force = state.TrueForce(imu.specific_force_mps2);
  const Eigen::Vector3d rate_before = state.TrueRate(imu.previous_rate_radps);
  const Eigen::Vector3d force_before = state.TrueForce(imu.previous_specific_force_mps2);

  const Eigen::Vector3d angle = rate * dt_s;
  const Eigen::Vector3d push = force * dt_s;
  const double twelfth = imu.duration_s * dt_s / 12.0;
  const Eigen::Vector3d coning = twelfth * rate_before.cross(rate);
  const Eigen::Vector3d sculling = twelfth * (rate_before.cross(force) + force_before.cross(rate));
  const Eigen::Vector3d turned =
      hold_attitude ? push : Eigen::Vector3d(push + 0.5 * angle.cross(push) + sculling);

  const Eigen::Vector3d earth = EarthRateNed(lat);
  const Eigen::Vector3d transport = TransportRateNed(lat, height, state.velocity_ned_mps);
  const Eigen::Vector3d frame = (earth + transport) * dt_s;
  Eigen::Vector3d gained = state.ned_from_body * turned;
  if (!hold_attitude) gained -= 0.5 * frame.cross(gained);
  const Eigen::Vector3d before = state.velocity_ned_mps;
  state.velocity_ned_mps += gained - (2.0 * earth + transport).cross(before) * dt_s;
  state.velocity_ned_mps.z() += NormalGravity(lat, height) * dt_s;
  state.position = Displaced(state.position, 0.5 * (before + state.velocity_ned_mps) * dt_s);

  if (!hold_attitude) {
    state.ned_from_body =
        (Rotation(-frame) * state.ned_from_body * Rotation(angle + coning)).normalized();
  }
  state.stamp += core::DurationFromSeconds(dt_s);
}

}  // namespace kawara::estimation
