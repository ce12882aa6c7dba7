#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/geodesy.hpp"
#include "estimation/earth.hpp"

/// A drive whose truth is a formula, for tests of navigation.
namespace kawara::testing {

/// The vehicle stands from `begin_s` to `end_s`; it brakes for kRamp before and pulls off after.
struct Stop {
  double begin_s = 0.0;
  double end_s = 0.0;
};

struct DrivePlan {
  core::Geodetic start{35.6 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 60.0};
  double yaw_rad = 0.5;
  double speed_mps = 2.0;
  double turning = 1.0;     ///< 0: straight on
  double undulating = 1.0;  ///< 0: level ground
  double duration_s = 60.0;
  std::vector<Stop> stops{{-10.0, 3.0}};  ///< ascending, none touching another
  /// The unit's axes against the vehicle's.
  double mount_pitch_rad = 0.0;
  double mount_yaw_rad = 0.0;
};

/// What is true at one instant; body is the inertial unit.
struct Truth {
  double t_s = 0.0;
  core::Geodetic position;
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Quaterniond ned_from_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();  ///< inertial, body
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
  double speed_mps = 0.0;
};

/// Speed, heading, climb and roll are sums of sines of a path time that stands still in stops; the
/// vehicle moves exactly along its forward axis. Velocity, rates and specific force follow in
/// closed form, only latitude, longitude and height are integrated (Runge-Kutta, 1e-10 m).
class DrivePath {
 public:
  explicit DrivePath(const DrivePlan& plan) : plan_(plan), position_(plan.start) {
    const double cp = std::cos(plan.mount_pitch_rad), sp = std::sin(plan.mount_pitch_rad);
    const double cy = std::cos(plan.mount_yaw_rad), sy = std::sin(plan.mount_yaw_rad);
    Eigen::Matrix3d vehicle_from_body;
    vehicle_from_body << cp * cy, cp * sy, -sp, -sy, cy, 0.0, sp * cy, sp * sy, cp;
    body_from_vehicle_ = vehicle_from_body.transpose();
  }

  double t_s() const { return t_s_; }
  Truth Now() const { return At(t_s_, position_); }

  /// Moves on; returns the integrals of angular rate [rad] and specific force [m/s] on the way.
  struct Increments {
    Eigen::Vector3d angle = Eigen::Vector3d::Zero();
    Eigen::Vector3d push = Eigen::Vector3d::Zero();
  };
  Increments MoveTo(double t_s) {
    Increments sum;
    constexpr double kLongestStep = 0.02;
    while (t_s_ < t_s) {
      const double step = t_s - t_s_ > kLongestStep ? kLongestStep : t_s - t_s_;
      const bool last = step == t_s - t_s_;
      const core::Geodetic from = position_;
      const Eigen::Vector3d k1 = Flow(t_s_, from);
      const Eigen::Vector3d k2 = Flow(t_s_ + 0.5 * step, Plus(from, 0.5 * step * k1));
      const Eigen::Vector3d k3 = Flow(t_s_ + 0.5 * step, Plus(from, 0.5 * step * k2));
      const Eigen::Vector3d k4 = Flow(t_s_ + step, Plus(from, step * k3));
      const Eigen::Vector3d way = step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      // Gauss-Legendre, three points.
      constexpr double kNode[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
      constexpr double kWeight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
      for (int i = 0; i < 3; ++i) {
        const Truth truth = At(t_s_ + kNode[i] * step, Plus(from, kNode[i] * way));
        sum.angle += kWeight[i] * step * truth.rate_radps;
        sum.push += kWeight[i] * step * truth.specific_force_mps2;
      }
      position_ = Plus(from, way);
      t_s_ = last ? t_s : t_s_ + step;
    }
    return sum;
  }

 private:
  static constexpr double kRamp = 2.0;  // s

  /// Path time, its rate and the rate of that.
  struct Progress {
    double tau = 0.0, rate = 1.0, change = 0.0;
  };
  Progress ProgressAt(double t) const {
    Progress p{t, 1.0, 0.0};
    for (const Stop& stop : plan_.stops) {
      const double braking = (t - (stop.begin_s - kRamp)) / kRamp;
      const double leaving = (t - stop.end_s) / kRamp;
      if (braking <= 0.0) break;
      if (braking < 1.0) {
        p.tau -= kRamp * RampIntegral(braking);
        p.rate = 1.0 - Ramp(braking);
        p.change = -RampSlope(braking) / kRamp;
      } else if (leaving < 0.0) {
        p.tau -= 0.5 * kRamp + (t - stop.begin_s);
        p.rate = 0.0;
      } else if (leaving < 1.0) {
        p.tau -=
            0.5 * kRamp + (stop.end_s - stop.begin_s) + kRamp * (leaving - RampIntegral(leaving));
        p.rate = Ramp(leaving);
        p.change = RampSlope(leaving) / kRamp;
      } else {
        p.tau -= kRamp + (stop.end_s - stop.begin_s);
      }
    }
    return p;
  }
  static double Ramp(double u) { return u * u * u * (10.0 + u * (6.0 * u - 15.0)); }
  static double RampSlope(double u) { return 30.0 * u * u * (1.0 - u) * (1.0 - u); }
  static double RampIntegral(double u) { return u * u * u * u * (2.5 + u * (u - 3.0)); }

  /// A sum of sines with its derivative by path time.
  struct Wave {
    double value = 0.0, slope = 0.0;
    void Add(double size, double period_s, double tau) {
      const double w = 2.0 * core::kPi / period_s;
      value += size * std::sin(w * tau);
      slope += size * w * std::cos(w * tau);
    }
  };

  struct Shape {
    Progress progress;
    Wave speed, yaw, pitch, roll;
  };
  Shape ShapeAt(double t) const {
    Shape s;
    s.progress = ProgressAt(t);
    const double tau = s.progress.tau;
    s.speed.value = plan_.speed_mps;
    s.speed.Add(0.35 * plan_.speed_mps, 23.0, tau);
    s.yaw.value = plan_.yaw_rad;
    s.yaw.Add(1.8 * plan_.turning, 61.0, tau);
    s.yaw.Add(0.7 * plan_.turning, 17.0, tau);
    s.pitch.Add(0.04 * plan_.undulating, 29.0, tau);
    s.roll.Add(0.05 * plan_.undulating, 13.0, tau);
    return s;
  }
  static Eigen::Vector3d VelocityOf(const Shape& s) {
    const double speed = s.speed.value * s.progress.rate;
    return speed * Eigen::Vector3d(std::cos(s.yaw.value) * std::cos(s.pitch.value),
                                   std::sin(s.yaw.value) * std::cos(s.pitch.value),
                                   -std::sin(s.pitch.value));
  }
  static core::Geodetic Plus(const core::Geodetic& g, const Eigen::Vector3d& d) {
    return {g.lat_rad + d.x(), g.lon_rad + d.y(), g.h_ellipsoidal_m + d.z()};
  }
  /// Rates of latitude, longitude, height.
  Eigen::Vector3d Flow(double t, const core::Geodetic& at) const {
    const Eigen::Vector3d v = VelocityOf(ShapeAt(t));
    const auto radii = estimation::RadiiAt(at.lat_rad);
    return {v.x() / (radii.meridian_m + at.h_ellipsoidal_m),
            v.y() / ((radii.prime_vertical_m + at.h_ellipsoidal_m) * std::cos(at.lat_rad)), -v.z()};
  }

  Truth At(double t, const core::Geodetic& position) const {
    const Shape s = ShapeAt(t);
    const double g = s.progress.rate;
    const double cy = std::cos(s.yaw.value), sy = std::sin(s.yaw.value);
    const double cp = std::cos(s.pitch.value), sp = std::sin(s.pitch.value);
    const double cr = std::cos(s.roll.value), sr = std::sin(s.roll.value);
    const double yaw_rate = s.yaw.slope * g, pitch_rate = s.pitch.slope * g;
    const double roll_rate = s.roll.slope * g;
    Truth truth;
    truth.t_s = t;
    truth.position = position;
    truth.speed_mps = s.speed.value * g;
    truth.velocity_ned_mps = VelocityOf(s);
    const Eigen::Matrix3d ned_from_vehicle =
        core::RotationNedFromBody({s.roll.value, s.pitch.value, s.yaw.value});
    const Eigen::Matrix3d vehicle_from_ned = ned_from_vehicle.transpose();
    truth.ned_from_body = Eigen::Quaterniond(ned_from_vehicle * body_from_vehicle_.transpose());

    const double pull = s.speed.slope * g * g + s.speed.value * s.progress.change;
    const Eigen::Vector3d acceleration =
        pull * Eigen::Vector3d(cy * cp, sy * cp, -sp) +
        truth.speed_mps * (yaw_rate * Eigen::Vector3d(-sy * cp, cy * cp, 0.0) +
                           pitch_rate * Eigen::Vector3d(-cy * sp, -sy * sp, -cp));
    const Eigen::Vector3d earth = estimation::EarthRateNed(position.lat_rad);
    const Eigen::Vector3d transport = estimation::TransportRateNed(
        position.lat_rad, position.h_ellipsoidal_m, truth.velocity_ned_mps);
    const Eigen::Vector3d gravity(
        0.0, 0.0, estimation::NormalGravity(position.lat_rad, position.h_ellipsoidal_m));
    const Eigen::Vector3d force =
        acceleration + (2.0 * earth + transport).cross(truth.velocity_ned_mps) - gravity;
    const Eigen::Vector3d turning(roll_rate - yaw_rate * sp, pitch_rate * cr + yaw_rate * sr * cp,
                                  yaw_rate * cr * cp - pitch_rate * sr);
    truth.specific_force_mps2 = body_from_vehicle_ * (vehicle_from_ned * force);
    truth.rate_radps = body_from_vehicle_ * (turning + vehicle_from_ned * (earth + transport));
    return truth;
  }

  DrivePlan plan_;
  Eigen::Matrix3d body_from_vehicle_;
  core::Geodetic position_;
  double t_s_ = 0.0;
};

}  // namespace kawara::testing
