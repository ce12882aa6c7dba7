#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/navigation_filter.hpp"

namespace kawara::estimation {

/// What is known when alignment begins.
struct AlignmentStart {
  core::GpsTime stamp;
  core::Geodetic antenna;  ///< position and velocity are its, too
  Eigen::Vector3d position_sd_ned_m = Eigen::Vector3d::Ones();
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  double velocity_sd_mps = 2.0;
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double level_sd_rad = 5.0 * core::kRadFromDeg;
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  double gyro_bias_sd_radps = 0.0;
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();  ///< measured, body: turns the antenna
  std::optional<double> heading_rad;                     ///< an idea of it, not more
  double heading_sd_rad = 0.0;
};

/// Heading unknown: twelve filters, 30 degrees apart, run side by side on the same data until the
/// data have told which of them is right. Works from rest and in motion; needs one straight push or
/// a metre or two of wheels. Source: the idea of the Gaussian-sum heading estimator of PX4's EKF2,
/// here with whole filters. Allocates when made only. One thread.
class HeadingBank {
 public:
  static constexpr int kHypotheses = 12;

  explicit HeadingBank(const NavigationConfig& config);

  bool running() const { return running_; }
  /// `calibrated`: a filter that ran before on the same vehicle (a gap in the samples ended it);
  /// what it had learned of sensors and mounting is taken over, with doubt. Null: nothing is known.
  void Start(const AlignmentStart& start, const NavigationFilter* calibrated);
  void Stop() { running_ = false; }

  void Advance(const ImuSample& sample, core::GpsTime stamp);
  void FinishSample(const ImuSample& sample);
  void Fuse(const NavMeasurement& measurement);

  /// The one that is left, if the data have decided.
  const NavigationFilter* Winner() const;
  /// Of the likeliest, with what all of them say of the heading in the deviation.
  NavSolution Solution() const;

 private:
  struct Mixture {
    int best = 0;
    double heading_sd_rad = 0.0;
  };
  Mixture Mix() const;

  const NavigationConfig* config_;
  std::vector<NavigationFilter> filters_;
  std::vector<double> prior_;  ///< logarithm
  bool running_ = false;
};

}  // namespace kawara::estimation
