#include "sim/vehicle/trajectory.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "sim/vehicle/ground_path.hpp"
#include "sim/vehicle/motion_plan.hpp"
#include "sim/vehicle/vibration.hpp"

namespace kawara::sim {
namespace {

/// The vibration's size follows the speed over this pitch.
constexpr double kGainPitch_s = 0.2;

const Eigen::Matrix3d& EnuFromNed() {
  static const Eigen::Matrix3d swap = (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
  return swap;
}

Eigen::Matrix3d EcefFromNed(const core::Geodetic& g) {
  const double sp = std::sin(g.lat_rad), cp = std::cos(g.lat_rad);
  const double sl = std::sin(g.lon_rad), cl = std::cos(g.lon_rad);
  return (Eigen::Matrix3d() << -sp * cl, -sl, -cp * cl, -sp * sl, cl, -cp * sl, cp, 0.0, -sp)
      .finished();
}

/// Ground under the four wheels, as a plane through the turning point.
struct Footing {
  double height_m = 0.0, pitch_rad = 0.0, roll_rad = 0.0;
};
Footing FootingAt(const VehicleConfig& vehicle, const GroundHeight& ground,
                  const Eigen::Vector2d& turning_point_m, double heading_rad) {
  if (!ground) return {};
  const Eigen::Vector2d ahead(std::sin(heading_rad), std::cos(heading_rad));
  const Eigen::Vector2d right(ahead.y(), -ahead.x());
  const double half_base = vehicle.wheelbase_m / 2.0;
  const double half_track = vehicle.track_m / 2.0;
  double mean = 0.0;
  double rise_ahead = 0.0;
  double rise_right = 0.0;
  for (const double a : {-1.0, 1.0}) {
    for (const double r : {-1.0, 1.0}) {
      const Eigen::Vector2d wheel = turning_point_m +
                                    (a * half_base - vehicle.turning_point_forward_m) * ahead +
                                    r * half_track * right;
      const double height = ground(wheel.x(), wheel.y());
      mean += height / 4.0;
      rise_ahead += a * height / (4.0 * half_base);
      rise_right += r * height / (4.0 * half_track);
    }
  }
  Footing footing;
  footing.height_m = mean + rise_ahead * vehicle.turning_point_forward_m;
  footing.pitch_rad = std::atan(rise_ahead);
  footing.roll_rad = -std::atan(rise_right * std::cos(footing.pitch_rad));
  return footing;
}

}  // namespace

struct Trajectory::Parts {
  Parts(GroundPath way, MotionPlan schedule, const VehicleConfig& v, const core::Geodetic& o,
        core::GpsTime start, std::uint64_t seed)
      : path(std::move(way)),
        plan(std::move(schedule)),
        vibration(v.vibration, seed),
        enu(o),
        begin(start),
        from_turning_point_m(-v.turning_point_forward_m, 0.0, -v.reference_height_m),
        ecef_from_ned(EcefFromNed(o)) {}

  /// Heading at a time from way and turn; as in AtSeconds().
  static double Heading(const GroundPath::Point& point, double turn_rad) {
    return point.heading_rad + turn_rad - point.turned_before_rad;
  }

  GroundPath path;
  MotionPlan plan;
  Vibration vibration;
  core::LocalEnu enu;
  core::GpsTime begin;
  Eigen::Vector3d from_turning_point_m;  ///< to the reference point, body axes
  Eigen::Matrix3d ecef_from_ned;         ///< at the origin
  SmoothSeries height_m, pitch_rad, roll_rad, gain;
};

core::Expected<Trajectory> Trajectory::Make(const VehicleConfig& vehicle, const PathConfig& path,
                                            const core::Geodetic& origin, core::GpsTime begin,
                                            const GroundHeight& ground, std::uint64_t seed) {
  core::Expected<GroundPath> line = GroundPath::Make(vehicle, path);
  if (!line) return tl::unexpected(line.error());
  MotionPlan plan(*line, vehicle.limits, path);
  const auto parts =
      std::make_shared<Parts>(std::move(*line), std::move(plan), vehicle, origin, begin, seed);
  const double duration_s = parts->plan.duration_s();
  std::vector<double> height_m, pitch_rad, roll_rad, gain;
  for (int i = 0; (i - 1) * vehicle.suspension_s < duration_s; ++i) {
    const double t_s = i * vehicle.suspension_s;
    const GroundPath::Point point = parts->path.At(parts->plan.WayAt(t_s)[0]);
    const Footing footing = FootingAt(vehicle, ground, point.position_m,
                                      Parts::Heading(point, parts->plan.TurnAt(t_s)[0]));
    height_m.push_back(footing.height_m);
    pitch_rad.push_back(footing.pitch_rad);
    roll_rad.push_back(footing.roll_rad);
  }
  for (int i = 0; (i - 1) * kGainPitch_s < duration_s; ++i) {
    const double t_s = i * kGainPitch_s;
    // Turning on the spot, the wheels at half the track move, too.
    const double speed_mps =
        std::hypot(parts->plan.WayAt(t_s)[1], parts->plan.TurnAt(t_s)[1] * vehicle.track_m / 2.0);
    gain.push_back(parts->vibration.GainAt(speed_mps));
  }
  parts->height_m = SmoothSeries(std::move(height_m), vehicle.suspension_s);
  parts->pitch_rad = SmoothSeries(std::move(pitch_rad), vehicle.suspension_s);
  parts->roll_rad = SmoothSeries(std::move(roll_rad), vehicle.suspension_s);
  parts->gain = SmoothSeries(std::move(gain), kGainPitch_s);
  return Trajectory(parts);
}

core::GpsTime Trajectory::begin() const { return parts_->begin; }
core::GpsTime Trajectory::end() const {
  return parts_->begin + core::DurationFromSeconds(parts_->plan.duration_s());
}
const core::Geodetic& Trajectory::origin() const { return parts_->enu.origin(); }

MotionState Trajectory::AtSeconds(double t_s) const {
  const SmoothSeries::Jet way = parts_->plan.WayAt(t_s);
  const SmoothSeries::Jet turn = parts_->plan.TurnAt(t_s);
  const GroundPath::Point point = parts_->path.At(way[0]);
  const SmoothSeries::Jet height = parts_->height_m.At(t_s);
  const SmoothSeries::Jet pitch = parts_->pitch_rad.At(t_s);
  const SmoothSeries::Jet roll = parts_->roll_rad.At(t_s);
  const Vibration::Shake shake = parts_->vibration.At(t_s, parts_->gain.At(t_s));

  const double r = roll[0] + shake.value[0], dr = roll[1] + shake.d1[0],
               ddr = roll[2] + shake.d2[0];
  const double p = pitch[0] + shake.value[1], dp = pitch[1] + shake.d1[1],
               ddp = pitch[2] + shake.d2[1];
  const double dy = point.heading_d1 * way[1] + turn[1];
  const double ddy = point.heading_d2 * way[1] * way[1] + point.heading_d1 * way[2] + turn[2];

  MotionState state;
  state.attitude = {core::WrapPi(r), p, core::WrapPi(Parts::Heading(point, turn[0]))};
  state.R_enu_body = EnuFromNed() * core::RotationNedFromBody(state.attitude);
  // Rates of ZYX angles in body axes, and their derivatives.
  const double sr = std::sin(r), cr = std::cos(r), sp = std::sin(p), cp = std::cos(p);
  state.rate_body_radps = {dr - dy * sp, dp * cr + dy * sr * cp, -dp * sr + dy * cr * cp};
  state.rate_dot_body_radps2 = {
      ddr - ddy * sp - dy * dp * cp,
      ddp * cr - dp * dr * sr + ddy * sr * cp + dy * dr * cr * cp - dy * dp * sr * sp,
      -ddp * sr - dp * dr * cr + ddy * cr * cp - dy * dr * sr * cp - dy * dp * cr * sp};

  // The turning point on the ground, lifted by the heave; from there to the reference point.
  state.position_enu_m << point.position_m, height[0] + shake.value[2];
  state.velocity_enu_mps << point.d1 * way[1], height[1] + shake.d1[2];
  state.acceleration_enu_mps2 << point.d2 * way[1] * way[1] + point.d1 * way[2],
      height[2] + shake.d2[2];
  const Eigen::Vector3d& lever = parts_->from_turning_point_m;
  const MotionState turning_point = state;
  state.position_enu_m = turning_point.PointEnu(lever);
  state.velocity_enu_mps = turning_point.PointVelocityEnu(lever);
  state.acceleration_enu_mps2 = turning_point.PointAccelerationEnu(lever);
  return state;
}

core::Geodetic Trajectory::GeodeticAt(core::GpsTime t, const Eigen::Vector3d& lever_frd_m) const {
  return parts_->enu.ToGeodetic(At(t).PointEnu(lever_frd_m));
}

Eigen::Matrix3d Trajectory::RotationNedFromEnu(const core::Geodetic& place) const {
  return EcefFromNed(place).transpose() * parts_->ecef_from_ned * EnuFromNed();
}

core::Attitude Trajectory::AttitudeAt(core::GpsTime t) const {
  const MotionState state = At(t);
  const core::Geodetic place = parts_->enu.ToGeodetic(state.position_enu_m);
  return core::AttitudeFromRotation(RotationNedFromEnu(place) * state.R_enu_body);
}

}  // namespace kawara::sim
