#include "estimation/error_state_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimation/earth.hpp"
#include "estimation/local_frame.hpp"
#include "estimation/rotation.hpp"

namespace kawara::estimation {
namespace {

using Column = Eigen::Map<Eigen::Vector3d>;

/// x <- F x of one column of errors. Position first, then velocity, then attitude: each uses the
/// old values of those behind it.
void ApplyTo(double* x, const Transition& f) {
  Column position(x + kPosition), velocity(x + kVelocity), attitude(x + kAttitude);
  const Column gyro_bias(x + kGyroBias), accel_bias(x + kAccelBias);
  const Column gyro_scale(x + kGyroScale), accel_scale(x + kAccelScale);
  position += f.dt_s * velocity;
  velocity.noalias() += f.velocity_attitude * attitude;
  velocity.noalias() +=
      f.velocity_accel_bias * (accel_bias + f.force.cwiseProduct(accel_scale)).eval();
  const Eigen::Vector3d turned = f.attitude_attitude * attitude;
  attitude += turned;
  Eigen::Vector3d rate_error = gyro_bias + f.rate.cwiseProduct(gyro_scale);
  rate_error.head<2>() += f.rate.z() * Eigen::Map<Eigen::Vector2d>(x + kGyroCross);
  attitude.noalias() += f.attitude_gyro_bias * rate_error;
}

/// columns first..first+2 of `out` += three columns of P times the transposed block.
using Rows = Eigen::Matrix<double, kErrorStates, 9>;
using Three = Eigen::Matrix<double, kErrorStates, 3>;
template <class Columns>
void AddProduct(Rows& out, int first, const Columns& columns, const Eigen::Matrix3d& block) {
  for (int i = 0; i < 3; ++i) {
    out.col(first + i) +=
        columns.col(0) * block(i, 0) + columns.col(1) * block(i, 1) + columns.col(2) * block(i, 2);
  }
}

/// P <- F P F^T, P symmetric. Only the first nine errors change.
void Transform(ErrorCovariance& p, const Transition& f) {
  // The first nine rows of F P, each as a column: so all work goes along columns.
  Rows rows = p.leftCols<9>();
  rows.middleCols<3>(kPosition) += f.dt_s * p.middleCols<3>(kVelocity);
  AddProduct(rows, kVelocity, p.middleCols<3>(kAttitude), f.velocity_attitude);
  Three force_error = p.middleCols<3>(kAccelBias);
  force_error += p.middleCols<3>(kAccelScale) * f.force.asDiagonal();
  AddProduct(rows, kVelocity, force_error, f.velocity_accel_bias);
  AddProduct(rows, kAttitude, p.middleCols<3>(kAttitude), f.attitude_attitude);
  Three rate_error = p.middleCols<3>(kGyroBias);
  rate_error += p.middleCols<3>(kGyroScale) * f.rate.asDiagonal();
  rate_error.leftCols<2>() += f.rate.z() * p.middleCols<2>(kGyroCross);
  AddProduct(rows, kAttitude, rate_error, f.attitude_gyro_bias);

  p.leftCols<9>() = rows;
  p.topRightCorner<9, kErrorStates - 9>() = rows.bottomRows<kErrorStates - 9>().transpose();
  // The first nine by nine still want F from the right. One half is taken for both: in rounding
  // they differ.
  for (int column = 0; column < 9; ++column) ApplyTo(rows.col(column).data(), f);
  for (int column = 0; column < 9; ++column) {
    for (int row = column; row < 9; ++row) p(row, column) = p(column, row) = rows(row, column);
  }
}

}  // namespace

void MeasurementRows::AddBlock(int first, const Eigen::Matrix3d& block) {
  for (int i = 0; i < 3; ++i) AddColumn(first + i, block.col(i));
}

void MeasurementRows::AddColumn(int which, const Eigen::Vector3d& column) {
  index[static_cast<std::size_t>(columns)] = which;
  value.col(columns) = column;
  ++columns;
}

void MeasurementRows::AddScalar(int which, double derivative) {
  AddColumn(which, {derivative, 0.0, 0.0});
}

double Innovation::LogLikelihood() const {
  return -0.5 * (nis + std::log(covariance.determinant()));
}

void ErrorStateFilter::Propagate(const ImuInterval& imu, double dt_s, const ImuNoise& noise,
                                 bool hold_attitude, double extra_acceleration, double extra_rate) {
  const Eigen::Matrix3d ned_from_body = state_.ned_from_body.toRotationMatrix();
  const Eigen::Vector3d force = state_.TrueForce(imu.specific_force_mps2);
  const Eigen::Vector3d rate = state_.TrueRate(imu.rate_radps);
  const double lat = state_.position.lat_rad;
  const Eigen::Vector3d frame =
      EarthRateNed(lat) +
      TransportRateNed(lat, state_.position.h_ellipsoidal_m, state_.velocity_ned_mps);

  Transition f;
  f.dt_s = dt_s;
  f.velocity_attitude = -dt_s * CrossMatrix(ned_from_body * force);
  f.velocity_accel_bias = -dt_s * ned_from_body;
  constexpr double kMeanTime = 0.2;  // s
  const double share = std::min(1.0, dt_s / kMeanTime);
  if (mean_force_mps2_.isZero()) mean_force_mps2_ = force;
  mean_force_mps2_ += share * (force - mean_force_mps2_);
  mean_rate_radps_ += share * (rate - mean_rate_radps_);
  f.force = mean_force_mps2_;
  f.rate = mean_rate_radps_;
  if (hold_attitude) {
    f.attitude_attitude.setZero();
    f.attitude_gyro_bias.setZero();
  } else {
    f.attitude_attitude = -dt_s * CrossMatrix(frame);
    f.attitude_gyro_bias = f.velocity_accel_bias;
  }
  Strapdown(state_, imu, dt_s, hold_attitude);
  Transform(covariance_, f);
  if (tape_ != nullptr) tape_->Add(f);

  // What one axis leaks into another is no noise; over the second or so that a turn or a push lasts
  // it adds up like noise of this density.
  constexpr double kLeakTime = 1.0;
  // Of the gyros the larger part, what a turn about z shows, is a state of its own.
  constexpr double kLeft = 0.3;
  const Eigen::Vector3d turning = kLeft * noise.gyro_misalignment * rate;
  const Eigen::Vector3d pushing =
      noise.accel_misalignment *
      (ned_from_body * force + Eigen::Vector3d(0, 0, NormalGravity(lat, 0.0)));
  const double gyro = noise.gyro_arw_rad_rts * noise.gyro_arw_rad_rts +
                      turning.squaredNorm() * kLeakTime + extra_rate * extra_rate;
  const double accel = noise.accel_vrw_mps_rts * noise.accel_vrw_mps_rts +
                       pushing.squaredNorm() * kLeakTime + extra_acceleration * extra_acceleration;
  covariance_.diagonal().segment<3>(kVelocity).array() += accel * dt_s;
  if (!hold_attitude) covariance_.diagonal().segment<3>(kAttitude).array() += gyro * dt_s;
  covariance_.diagonal().segment<3>(kGyroBias).array() +=
      noise.gyro_bias_rw * noise.gyro_bias_rw * dt_s;
  covariance_.diagonal().segment<3>(kAccelBias).array() +=
      noise.accel_bias_rw * noise.accel_bias_rw * dt_s;
}

void ErrorStateFilter::Decay(int first, std::span<const double> variance, double dt_s,
                             double time_constant_s) {
  if (dt_s <= 0.0) return;
  const double factor = std::exp(-dt_s / time_constant_s);
  const int count = static_cast<int>(variance.size());
  covariance_.middleRows(first, count) *= factor;
  covariance_.middleCols(first, count) *= factor;
  for (int i = 0; i < count; ++i) {
    covariance_(first + i, first + i) +=
        variance[static_cast<std::size_t>(i)] * (1.0 - factor * factor);
  }
  if (first == kGnssColoured) state_.gnss_coloured_ned_m *= factor;
  if (first == kAhrsHeading) state_.ahrs_heading_rad *= factor;
  if (tape_ != nullptr) tape_->AddDecay(first, count, factor);
}

void ErrorStateFilter::Doubt(int first, const Eigen::Vector3d& variance) {
  covariance_.diagonal().segment<3>(first) += variance;
}

void ErrorStateFilter::Forget(int first, const Eigen::Vector3d& variance) {
  covariance_.middleRows<3>(first).setZero();
  covariance_.middleCols<3>(first).setZero();
  covariance_.diagonal().segment<3>(first) = variance;
  if (tape_ != nullptr) tape_->AddForget(first, 3);
}

void ErrorStateFilter::Turn(const Eigen::Vector3d& measured_angle_rad, double elapsed_s,
                            const ImuNoise& noise) {
  if (elapsed_s <= 0.0) return;
  Transition f;
  f.dt_s = 0.0;
  f.velocity_attitude.setZero();
  f.velocity_accel_bias.setZero();
  f.attitude_attitude.setZero();
  f.attitude_gyro_bias = -elapsed_s * state_.ned_from_body.toRotationMatrix();
  f.force.setZero();
  f.rate = state_.TrueRate(measured_angle_rad / elapsed_s);
  const Eigen::Vector3d earth = EarthRateNed(state_.position.lat_rad) * elapsed_s;
  state_.ned_from_body =
      (Rotation(-earth) * state_.ned_from_body * Rotation(f.rate * elapsed_s)).normalized();
  Transform(covariance_, f);
  covariance_.diagonal().segment<3>(kAttitude).array() +=
      noise.gyro_arw_rad_rts * noise.gyro_arw_rad_rts * elapsed_s;
  if (tape_ != nullptr) tape_->Add(f);
}

Innovation ErrorStateFilter::Predict(const MeasurementRows& rows) const {
  Innovation innovation;
  innovation.rows = rows.rows;
  innovation.residual.head(rows.rows) = rows.residual.head(rows.rows);
  innovation.cross.setZero();
  for (int i = 0; i < rows.columns; ++i) {
    const auto column = covariance_.col(rows.index[static_cast<std::size_t>(i)]);
    for (int r = 0; r < rows.rows; ++r) innovation.cross.col(r) += rows.value(r, i) * column;
  }
  Eigen::Matrix3d s = Eigen::Matrix3d::Zero();
  for (int i = 0; i < rows.columns; ++i) {
    s.noalias() +=
        rows.value.col(i) * innovation.cross.row(rows.index[static_cast<std::size_t>(i)]);
  }
  s += rows.noise;
  for (int r = 0; r < rows.rows; ++r) {
    for (int c = 0; c < rows.rows; ++c) innovation.covariance(r, c) = 0.5 * (s(r, c) + s(c, r));
  }
  const Eigen::LLT<Eigen::Matrix3d> llt(innovation.covariance);
  innovation.nis = llt.matrixL().solve(innovation.residual).squaredNorm();
  return innovation;
}

void ErrorStateFilter::Update(const MeasurementRows& rows, const Innovation& innovation) {
  // Whitened by the Cholesky factor of S the rows are independent with variance 1, and the gain is
  // P H^T itself; the product with its own transpose keeps P exactly symmetric.
  const Eigen::LLT<Eigen::Matrix3d> llt(innovation.covariance);
  FilterTape::Update update;
  update.gain = llt.matrixL().solve(innovation.cross.transpose()).transpose();
  update.innovation = llt.matrixL().solve(innovation.residual);
  for (int row = innovation.rows; row < 3; ++row) {
    update.gain.col(row).setZero();
    update.innovation(row) = 0.0;
  }
  const ErrorVector error = update.gain * update.innovation;
  const auto& gain = update.gain;
  for (int column = 0; column < kErrorStates; ++column) {
    auto of = covariance_.col(column);
    if (innovation.rows == 1) {
      of -= gain.col(0) * gain(column, 0);
    } else {
      of -= gain.col(0) * gain(column, 0) + gain.col(1) * gain(column, 1) +
            gain.col(2) * gain(column, 2);
    }
  }
  state_.Correct(error);
  if (tape_ == nullptr) return;
  update.h.setZero();
  for (int i = 0; i < rows.columns; ++i) {
    Eigen::Vector3d column = Eigen::Vector3d::Zero();
    column.head(rows.rows) = rows.value.col(i).head(rows.rows);
    update.h.row(rows.index[static_cast<std::size_t>(i)]) = llt.matrixL().solve(column).transpose();
  }
  tape_->Add(update, innovation.rows);
}

}  // namespace kawara::estimation
