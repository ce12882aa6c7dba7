#include "estimation/measurement_models.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/earth.hpp"
#include "estimation/local_frame.hpp"

namespace kawara::estimation {
namespace {

double Square(double v) { return v * v; }

core::Attitude AttitudeOf(const NominalState& state) {
  return core::AttitudeFromRotation(state.ned_from_body.toRotationMatrix());
}

MeasurementRows YawRow(const NominalState& state, double predicted_offset_rad, double heading_rad,
                       double sd_rad) {
  const core::Attitude attitude = AttitudeOf(state);
  const Eigen::Matrix3d euler = EulerFromRotationVector(attitude);
  MeasurementRows rows;
  rows.rows = 1;
  rows.residual.x() = core::WrapPi(heading_rad - attitude.yaw_rad - predicted_offset_rad);
  rows.noise(0, 0) = Square(sd_rad);
  for (int i = 0; i < 3; ++i) rows.AddScalar(kAttitude + i, euler(2, i));
  return rows;
}

/// Vehicle axes from IMU axes, and its derivatives by the mounting angles. A sprung body leans
/// under acceleration, and tyres slip: both turn the axes by an angle in proportion.
struct Mounting {
  Eigen::Matrix3d vehicle_from_body;
  Eigen::Matrix3d by_pitch;
  Eigen::Matrix3d by_yaw;
};
Mounting MountingOf(const NominalState& state, const Eigen::Vector3d& acceleration_body_mps2) {
  const double pitch_rad =
      state.mount_pitch_rad + state.squat_rad_per_mps2 * acceleration_body_mps2.x();
  const double yaw_rad =
      state.mount_yaw_rad + state.sideslip_rad_per_mps2 * acceleration_body_mps2.y();
  const double cp = std::cos(pitch_rad), sp = std::sin(pitch_rad);
  const double cy = std::cos(yaw_rad), sy = std::sin(yaw_rad);
  Mounting m;
  m.vehicle_from_body << cp * cy, cp * sy, -sp, -sy, cy, 0.0, sp * cy, sp * sy, cp;
  m.by_pitch << -sp * cy, -sp * sy, -cp, 0.0, 0.0, 0.0, cp * cy, cp * sy, -sp;
  m.by_yaw << -cp * sy, cp * cy, 0.0, -cy, -sy, 0.0, -sp * sy, sp * cy, 0.0;
  return m;
}

/// Velocity of the axle in the vehicle's axes with its derivatives.
struct AxleVelocity {
  Eigen::Vector3d vehicle_mps;
  Eigen::Matrix3d by_velocity;
  Eigen::Matrix3d by_attitude;
  Eigen::Matrix3d by_gyro_bias;
  Eigen::Vector3d by_pitch;
  Eigen::Vector3d by_yaw;
  Eigen::Vector3d by_axle;
  Eigen::Vector3d by_squat;
  Eigen::Vector3d by_sideslip;
};
AxleVelocity AxleVelocityOf(const NominalState& state, const BodyMotion& motion) {
  const Eigen::Matrix3d body_from_ned = state.ned_from_body.toRotationMatrix().transpose();
  const Eigen::Vector3d acceleration = body_from_ned * motion.acceleration_mps2;
  const Mounting mounting = MountingOf(state, acceleration);
  const Eigen::Vector3d axle(state.axle_m, 0.0, 0.0);
  const Eigen::Vector3d body =
      body_from_ned * state.velocity_ned_mps + motion.rate_radps.cross(axle);
  AxleVelocity v;
  v.vehicle_mps = mounting.vehicle_from_body * body;
  v.by_velocity = mounting.vehicle_from_body * body_from_ned;
  v.by_attitude = v.by_velocity * CrossMatrix(state.velocity_ned_mps);
  v.by_gyro_bias = mounting.vehicle_from_body * CrossMatrix(axle);
  v.by_pitch = mounting.by_pitch * body;
  v.by_yaw = mounting.by_yaw * body;
  v.by_squat = acceleration.x() * v.by_pitch;
  v.by_sideslip = acceleration.y() * v.by_yaw;
  v.by_axle = mounting.vehicle_from_body * motion.rate_radps.cross(Eigen::Vector3d::UnitX()).eval();
  return v;
}

}  // namespace

GnssGrade GradeOf(core::RtkState rtk) {
  if (rtk == core::RtkState::kFixed) return GnssGrade::kFixed;
  return rtk == core::RtkState::kFloat ? GnssGrade::kFloat : GnssGrade::kCode;
}

Eigen::Vector3d StatedVarianceNed(const core::GnssFix& fix, const GnssErrors& errors) {
  const Eigen::Vector3d enu = fix.position_cov_enu_m2.diagonal();
  return Eigen::Vector3d(enu.y(), enu.x(), enu.z()).cwiseMax(Square(errors.min_position_sd_m));
}

ColouredShare ShareOf(GnssGrade grade, const GnssErrors& errors) {
  if (grade == GnssGrade::kFixed) {
    return {errors.white_share, errors.coloured_share, errors.coloured_time_s};
  }
  return {errors.float_white_share, errors.float_coloured_share, errors.float_coloured_time_s};
}

MeasurementRows PositionRows(const NominalState& state, const BodyMotion& motion,
                             const core::GnssFix& fix, double shift_s,
                             const NavigationConfig& config) {
  const Eigen::Matrix3d ned_from_body = state.ned_from_body.toRotationMatrix();
  const Eigen::Vector3d& lever = config.lever_arm_frd_m;
  const Eigen::Vector3d arm = ned_from_body * lever;
  const Eigen::Vector3d sway = ned_from_body * motion.rate_radps.cross(lever);
  const double tau = shift_s - state.time_offset_s;
  const Eigen::Vector3d velocity = state.velocity_ned_mps + sway;

  MeasurementRows rows;
  rows.rows = 3;
  rows.residual = Displacement(state.position, fix.antenna) - arm - velocity * tau -
                  0.5 * tau * tau * motion.acceleration_mps2 - state.gnss_coloured_ned_m;
  // The receiver's covariance keeps its shape; shares and floor scale its axes.
  const ColouredShare share = ShareOf(GradeOf(fix.rtk), config.gnss);
  const Eigen::Matrix3d ned_from_enu = EnuFromNed();
  const Eigen::Matrix3d stated = ned_from_enu * fix.position_cov_enu_m2 * ned_from_enu.transpose();
  const Eigen::Vector3d floored = StatedVarianceNed(fix, config.gnss);
  rows.noise = Square(share.white) * stated;
  // A share of a tiny deviation is no deviation: receivers round and quantise.
  constexpr double kWhiteFloor = 0.5;  // of the floor of the whole
  rows.noise.diagonal() =
      (Square(share.white) * floored).cwiseMax(Square(kWhiteFloor * config.gnss.min_position_sd_m));
  rows.AddBlock(kPosition, Eigen::Matrix3d::Identity());
  rows.AddBlock(kVelocity, tau * Eigen::Matrix3d::Identity());
  rows.AddBlock(kAttitude, -CrossMatrix(arm));
  rows.AddBlock(kGnssColoured, Eigen::Matrix3d::Identity());
  rows.AddColumn(kTimeOffset, -(velocity + tau * motion.acceleration_mps2));
  return rows;
}

MeasurementRows GnssVelocityRows(const NominalState& state, const BodyMotion& motion,
                                 const core::GnssFix& fix, double shift_s,
                                 const NavigationConfig& config) {
  const Eigen::Matrix3d ned_from_body = state.ned_from_body.toRotationMatrix();
  const Eigen::Vector3d& lever = config.lever_arm_frd_m;
  const Eigen::Vector3d sway = ned_from_body * motion.rate_radps.cross(lever);
  const double tau = shift_s - state.time_offset_s - state.velocity_delay_s;

  MeasurementRows rows;
  rows.rows = 3;
  rows.residual = NedFromEnu(fix.velocity_enu_mps) - state.velocity_ned_mps - sway -
                  tau * motion.acceleration_mps2;
  const Eigen::Vector3d& enu_sd = fix.velocity_sd_enu_mps;
  const Eigen::Vector3d sd =
      Eigen::Vector3d(enu_sd.y(), enu_sd.x(), enu_sd.z()).cwiseMax(config.gnss.velocity_floor_mps);
  // A receiver smooths its velocity over a time nobody states: some hundredths of a second of
  // acceleration stay uncertain beyond the delay that is estimated.
  constexpr double kSmoothing = 0.05;
  rows.noise.diagonal() =
      sd.cwiseAbs2() + Square(kSmoothing) * motion.acceleration_mps2.cwiseAbs2();
  rows.AddBlock(kVelocity, Eigen::Matrix3d::Identity());
  rows.AddBlock(kAttitude, -CrossMatrix(sway));
  rows.AddBlock(kGyroBias, ned_from_body * CrossMatrix(lever));
  rows.AddColumn(kTimeOffset, -motion.acceleration_mps2);
  rows.AddColumn(kVelocityDelay, -motion.acceleration_mps2);
  return rows;
}

MeasurementRows HeadingRows(const NominalState& state, double heading_rad, double sd_rad) {
  return YawRow(state, 0.0, heading_rad, sd_rad);
}

MeasurementRows AhrsHeadingRows(const NominalState& state, double heading_rad, double sd_rad) {
  MeasurementRows rows = YawRow(state, state.ahrs_heading_rad, heading_rad, sd_rad);
  rows.AddScalar(kAhrsHeading, 1.0);
  return rows;
}

MeasurementRows LevelRows(const NominalState& state, const core::Attitude& attitude,
                          double sd_rad) {
  const core::Attitude predicted = AttitudeOf(state);
  Eigen::Matrix3d euler = EulerFromRotationVector(predicted);
  euler.row(2).setZero();
  MeasurementRows rows;
  rows.rows = 2;
  rows.residual = {core::WrapPi(attitude.roll_rad - predicted.roll_rad),
                   core::WrapPi(attitude.pitch_rad - predicted.pitch_rad), 0.0};
  rows.noise.diagonal() = Eigen::Vector3d(Square(sd_rad), Square(sd_rad), 0.0);
  rows.AddBlock(kAttitude, euler);
  return rows;
}

Eigen::Vector3d VehicleVelocity(const NominalState& state, const BodyMotion& motion) {
  return AxleVelocityOf(state, motion).vehicle_mps;
}

MeasurementRows SpeedRows(const NominalState& state, const BodyMotion& motion, double speed_mps,
                          double sd_mps) {
  const AxleVelocity v = AxleVelocityOf(state, motion);
  const double scale = 1.0 + state.speed_scale;
  MeasurementRows rows;
  rows.rows = 1;
  rows.residual.x() = speed_mps - scale * v.vehicle_mps.x();
  rows.noise(0, 0) = Square(sd_mps);
  for (int i = 0; i < 3; ++i) {
    rows.AddScalar(kVelocity + i, scale * v.by_velocity(0, i));
    rows.AddScalar(kAttitude + i, scale * v.by_attitude(0, i));
  }
  rows.AddScalar(kSpeedScale, v.vehicle_mps.x());
  rows.AddScalar(kMountPitch, scale * v.by_pitch.x());
  rows.AddScalar(kMountYaw, scale * v.by_yaw.x());
  rows.AddScalar(kAxle, scale * v.by_axle.x());
  rows.AddScalar(kSquat, scale * v.by_squat.x());
  rows.AddScalar(kSideslip, scale * v.by_sideslip.x());
  return rows;
}

MeasurementRows ConstraintRows(const NominalState& state, const BodyMotion& motion,
                               double right_sd_mps, double down_sd_mps) {
  const AxleVelocity v = AxleVelocityOf(state, motion);
  const auto lower = [](const auto& m) -> Eigen::Vector3d { return {m.y(), m.z(), 0.0}; };
  const auto lower_rows = [](const Eigen::Matrix3d& m) {
    Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
    out.topRows<2>() = m.bottomRows<2>();
    return out;
  };
  MeasurementRows rows;
  rows.rows = 2;
  rows.residual = -lower(v.vehicle_mps);
  rows.noise.diagonal() = Eigen::Vector3d(Square(right_sd_mps), Square(down_sd_mps), 0.0);
  rows.AddBlock(kVelocity, lower_rows(v.by_velocity));
  rows.AddBlock(kAttitude, lower_rows(v.by_attitude));
  rows.AddBlock(kGyroBias, lower_rows(v.by_gyro_bias));
  rows.AddColumn(kMountPitch, lower(v.by_pitch));
  rows.AddColumn(kMountYaw, lower(v.by_yaw));
  rows.AddColumn(kAxle, lower(v.by_axle));
  rows.AddColumn(kSquat, lower(v.by_squat));
  rows.AddColumn(kSideslip, lower(v.by_sideslip));
  return rows;
}

MeasurementRows TurnRateRows(const NominalState& state, const Eigen::Vector3d& measured_rate_radps,
                             double turn_rate_radps, double sd_radps) {
  const double scale = 1.0 + state.turn_scale;
  const double turning = state.TrueRate(measured_rate_radps).z();
  MeasurementRows rows;
  rows.rows = 1;
  rows.residual.x() = turn_rate_radps - scale * turning;
  rows.noise(0, 0) = Square(sd_radps);
  rows.AddScalar(kGyroBias + 2, -scale);
  rows.AddScalar(kGyroScale + 2, -scale * turning);
  rows.AddScalar(kTurnScale, turning);
  return rows;
}

MeasurementRows ZeroVelocityRows(const NominalState& state, double sd_mps) {
  MeasurementRows rows;
  rows.rows = 3;
  rows.residual = -state.velocity_ned_mps;
  rows.noise.diagonal().setConstant(Square(sd_mps));
  rows.AddBlock(kVelocity, Eigen::Matrix3d::Identity());
  return rows;
}

MeasurementRows ZeroRateRows(const NominalState& state, const Eigen::Vector3d& measured_radps,
                             double sd_radps) {
  const Eigen::Vector3d earth =
      state.ned_from_body.conjugate() * EarthRateNed(state.position.lat_rad);
  MeasurementRows rows;
  rows.rows = 3;
  rows.residual = measured_radps - state.gyro_bias_radps -
                  earth.cwiseProduct(Eigen::Vector3d::Ones() + state.gyro_scale);
  rows.noise.diagonal().setConstant(Square(sd_radps));
  rows.AddBlock(kGyroBias, Eigen::Matrix3d::Identity());
  return rows;
}

}  // namespace kawara::estimation
