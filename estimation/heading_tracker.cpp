#include "estimation/heading_tracker.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::estimation {
namespace {

double Square(double v) { return v * v; }

/// Courses refused in a row before the tracker believes them rather than itself.
constexpr int kMaxRefused = 10;

}  // namespace

HeadingTracker::HeadingTracker(const HeadingConfig& config) : config_(config) {}

double HeadingTracker::sigma_rad() const {
  return known_ ? std::min(std::sqrt(variance_), core::kPi) : core::kPi;
}

void HeadingTracker::Elapse(double seconds, bool magnetic) {
  if (!magnetic) {
    variance_ += Square(config_.gyro_wander_rad) * seconds;
    return;
  }
  const double stationary = Square(config_.magnetic_sigma_rad);
  if (!known_) return Begin(0.0, stationary);
  // First-order Gauss-Markov: forgets towards zero at the pace that keeps the stationary variance.
  const double keep = std::exp(-0.5 * Square(config_.magnetic_wander_rad) / stationary * seconds);
  offset_rad_ *= keep;
  variance_ = variance_ * keep * keep + stationary * (1.0 - keep * keep);
}

void HeadingTracker::AddCourse(double reference_yaw_rad, double course_rad, double speed_mps,
                               double velocity_sigma_mps) {
  if (!(speed_mps >= config_.min_course_speed_mps)) return;
  const double velocity_sigma = std::max(velocity_sigma_mps, config_.velocity_floor_mps);
  const double measurement_var =
      Square(config_.course_sigma_rad) + Square(velocity_sigma / speed_mps);
  if (!known_) {
    Begin(core::WrapPi(course_rad - reference_yaw_rad), measurement_var);
    ++course_updates_;
    return;
  }
  double innovation = core::WrapPi(course_rad - reference_yaw_rad - offset_rad_);
  if (std::abs(innovation) > core::kPi / 2.0) innovation = core::WrapPi(innovation + core::kPi);
  if (std::abs(innovation) > 4.0 * std::sqrt(variance_ + measurement_var)) {
    ++course_refused_;
    if (++refused_in_row_ < kMaxRefused) return;
    variance_ += Square(innovation);
  }
  refused_in_row_ = 0;
  ++course_updates_;
  Update(innovation, measurement_var);
}

void HeadingTracker::AddHeading(double reference_yaw_rad, double heading_rad, double sigma_rad) {
  const double offset = core::WrapPi(heading_rad - reference_yaw_rad);
  if (!known_) return Begin(offset, Square(sigma_rad));
  const double innovation = core::WrapPi(offset - offset_rad_);
  // Two antennas are never 180 degrees wrong: rather than refuse, doubt oneself.
  if (std::abs(innovation) > 4.0 * std::sqrt(variance_ + Square(sigma_rad))) {
    variance_ += Square(innovation);
  }
  Update(innovation, Square(sigma_rad));
}

void HeadingTracker::Update(double innovation_rad, double measurement_var) {
  const double gain = variance_ / (variance_ + measurement_var);
  offset_rad_ = core::WrapPi(offset_rad_ + gain * innovation_rad);
  variance_ *= 1.0 - gain;
}

void HeadingTracker::Begin(double offset_rad, double variance) {
  known_ = true;
  offset_rad_ = offset_rad;
  variance_ = variance;
  refused_in_row_ = 0;
}

}  // namespace kawara::estimation
