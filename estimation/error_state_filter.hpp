#pragma once
#include <Eigen/Core>
#include <array>
#include <span>

#include "estimation/error_state.hpp"
#include "estimation/filter_tape.hpp"
#include "estimation/sensor_profile.hpp"
#include "estimation/strapdown.hpp"

namespace kawara::estimation {

/// Up to three rows of a linearised measurement: residual = measured - predicted, H the derivative
/// of the measurement by the errors, of which only `columns` are not zero.
struct MeasurementRows {
  static constexpr int kMaxColumns = 20;

  int rows = 0;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();  ///< covariance of the measurement
  int columns = 0;
  std::array<int, kMaxColumns> index{};
  Eigen::Matrix<double, 3, kMaxColumns> value;

  /// Derivative by errors first..first+2.
  void AddBlock(int first, const Eigen::Matrix3d& block);
  void AddColumn(int which, const Eigen::Vector3d& column);
  /// Of the row alone where rows == 1.
  void AddScalar(int which, double derivative);
};

/// A measurement against the prediction, before anybody decides to use it.
struct Innovation {
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of the residual; I beyond `rows`
  Eigen::Matrix<double, kErrorStates, 3> cross;  ///< covariance of errors and prediction
  int rows = 0;
  double nis = 0.0;  ///< normalised innovation squared

  double LogLikelihood() const;  ///< without the constant
};

/// Kalman filter of the errors of a strapdown navigation: mechanisation, covariance, corrections.
/// It judges nothing; see NavigationFilter. Source of the error equations: Groves, Principles of
/// GNSS, Inertial, and Multisensor Integrated Navigation Systems (2013), 14.2.4, with the terms
/// dropped that stay under 1 % of a minute's drift of a MEMS unit (transport rate, change of
/// gravity, Coriolis of a velocity error).
/// Copyable (11 KB) and without heap, so a copy is a checkpoint. One thread.
class ErrorStateFilter {
 public:
  ErrorStateFilter() = default;
  ErrorStateFilter(const NominalState& state, const ErrorCovariance& covariance)
      : state_(state), covariance_(covariance) {}

  const NominalState& state() const { return state_; }
  const ErrorCovariance& covariance() const { return covariance_; }
  void SetTape(FilterTape* tape) { tape_ = tape; }
  FilterTape* tape() const { return tape_; }

  /// `hold_attitude`: standing still, the gyros are not asked. `extra_acceleration`,
  /// `extra_rate`: what nobody measured in this step (a gap), spectral [unit sqrt(s)].
  void Propagate(const ImuInterval& imu, double dt_s, const ImuNoise& noise, bool hold_attitude,
                 double extra_acceleration = 0.0, double extra_rate = 0.0);
  /// Errors from `first` on, as many as `variance` has, fade with this time constant and have that
  /// variance in the steady state (first-order Gauss-Markov).
  void Decay(int first, std::span<const double> variance, double dt_s, double time_constant_s);
  /// Adds to the variance of errors first...: random walk, or doubt.
  void Doubt(int first, const Eigen::Vector3d& variance);
  void Doubt(int which, double variance) { covariance_(which, which) += variance; }
  /// Errors first..first+2 begin anew: independent, this variance. The nominal value is the
  /// caller's, by Renew.
  void Forget(int first, const Eigen::Vector3d& variance);
  void SetColoured(const Eigen::Vector3d& value) { state_.gnss_coloured_ned_m = value; }
  /// Turns the body by an angle (measured, uncorrected) that the gyros saw in the last `elapsed_s`
  /// and Propagate was told to hold.
  void Turn(const Eigen::Vector3d& measured_angle_rad, double elapsed_s, const ImuNoise& noise);
  void SetStamp(core::GpsTime stamp) { state_.stamp = stamp; }

  Innovation Predict(const MeasurementRows& rows) const;
  void Update(const MeasurementRows& rows, const Innovation& innovation);

 private:
  NominalState state_;
  ErrorCovariance covariance_ = ErrorCovariance::Zero();
  FilterTape* tape_ = nullptr;
  /// Of late. The derivatives by the scales take these, not the sample: its noise is in what it did
  /// to the velocity as well, and the product would pass for a scale that is too large.
  Eigen::Vector3d mean_force_mps2_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_rate_radps_ = Eigen::Vector3d::Zero();
};

}  // namespace kawara::estimation
