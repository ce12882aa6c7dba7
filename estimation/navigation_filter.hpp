#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <variant>

#include "core/measurements.hpp"
#include "estimation/error_state_filter.hpp"
#include "estimation/fix_trust.hpp"
#include "estimation/measurement_models.hpp"
#include "estimation/nav_types.hpp"
#include "estimation/navigation_config.hpp"
#include "estimation/navigation_stats.hpp"
#include "estimation/standstill.hpp"

namespace kawara::estimation {

/// A measurement at its place among the inertial samples.
struct NavMeasurement {
  core::GpsTime stamp;   ///< validity on the IMU's time scale
  double shift_s = 0.0;  ///< GNSS: epoch minus stamp, the offset that was believed when it came
  std::variant<core::GnssFix, OdometrySample, AttitudeSample> data;
};

/// The filter in order of time: samples and measurements must come as they happened (Navigator sees
/// to that). Decides what is believed: gates, trust in fixes, slipping wheels, standing still, how
/// far the vehicle keeps to its wheels' direction. Copyable without heap: a copy is a checkpoint,
/// going on from it repeats exactly what was. One thread.
class NavigationFilter {
 public:
  /// `config` must outlive the filter and its copies.
  NavigationFilter(const NavigationConfig& config, const NominalState& state,
                   const ErrorCovariance& covariance);

  /// A hypothesis among others: believes every measurement, and adds up how likely it was.
  void SetHypothesis(bool on) { hypothesis_ = on; }
  double log_likelihood() const { return log_likelihood_; }

  /// Moves on to `stamp`, which lies in the interval that ends with `sample`.
  void Advance(const ImuSample& sample, core::GpsTime stamp);
  /// The sample is used up; its end is where the filter stands.
  void FinishSample(const ImuSample& sample);
  void Fuse(const NavMeasurement& measurement);

  NavSolution Solution() const;
  const ErrorStateFilter& errors() const { return filter_; }
  const NominalState& state() const { return filter_.state(); }
  const NavigationStats& stats() const { return stats_; }
  void SetTape(FilterTape* tape) { filter_.SetTape(tape); }
  void WriteNode();

  /// To be ADDED to IMU stamps to get GNSS time.
  struct TimeOffset {
    double value_s = 0.0;
    double sd_s = 0.0;
  };
  TimeOffset time_offset() const;
  /// GNSS velocities are that much older than their epochs.
  TimeOffset velocity_delay() const;
  /// The filter contradicts its fixes again and again: heading or position is altogether wrong.
  bool lost() const { return lost_; }
  bool standing_still() const { return holding_; }

 private:
  using Source = NavSource;
  /// One wild measurement does not decide between hypotheses.
  static constexpr double kLikelihoodCap = 60.0;

  void FuseFix(const core::GnssFix& fix, double shift_s);
  void FusePosition(const core::GnssFix& fix, double shift_s);
  void FuseOdometry(const OdometrySample& sample);
  void FuseAttitude(const AttitudeSample& sample);
  void FuseConstraint();
  void AgePosition(const core::GnssFix& fix, GnssGrade grade);
  void Concede(const Innovation& innovation);
  void OnBlock(const StandstillDetector::Block& block);
  bool SpeedIsZero() const;
  void StopHolding();
  BodyMotion Motion() const;
  /// Gate and update; true if used.
  bool Offer(Source source, const MeasurementRows& rows, double gate);
  void Use(Source source, const MeasurementRows& rows, const Innovation& innovation);
  double SecondsSince(core::GpsTime earlier) const;

  /// Spread of a residual, learned while the fixes are good.
  struct Learned {
    double variance = 0.09;
    void Add(double residual, double share) {
      variance += share * (residual * residual - variance);
    }
  };

  const NavigationConfig* config_;
  ErrorStateFilter filter_;
  FixTrust trust_;
  StandstillDetector standstill_;
  NavigationStats stats_;

  ImuSample sample_;         ///< the one Advance was called with last
  ImuSample sample_before_;  ///< the one before it
  bool has_sample_ = false;
  bool has_sample_before_ = false;
  Eigen::Vector3d acceleration_mps2_ = Eigen::Vector3d::Zero();  ///< NED, smoothed over 0.1 s

  bool holding_ = false;  ///< standing still: attitude does not follow the gyros
  Eigen::Vector3d held_angle_rad_ = Eigen::Vector3d::Zero();
  double held_s_ = 0.0;

  core::GpsTime last_position_;  ///< believed
  core::GpsTime last_coloured_;  ///< lasting error of positions is aged up to here
  core::GpsTime last_velocity_;
  core::GpsTime last_wheels_;
  core::GpsTime wheels_moved_;
  core::GpsTime last_speed_used_;
  core::GpsTime last_constraint_;
  core::GpsTime last_ahrs_;
  core::GpsTime last_reset_;
  core::GpsTime last_gap_;
  GnssGrade grade_ = GnssGrade::kCode;  ///< of the last believed position
  GnssGrade coloured_grade_ = GnssGrade::kCode;
  bool coloured_set_ = false;
  double gnss_speed_mps_ = 0.0;
  double gnss_speed_limit_mps_ = 0.0;
  int slips_in_row_ = 0;
  Learned right_, down_;
  double published_offset_s_ = 0.0;
  bool in_outage_ = false;
  bool refused_last_ = false;
  bool lost_ = false;
  bool hypothesis_ = false;
  double log_likelihood_ = 0.0;
};

}  // namespace kawara::estimation
