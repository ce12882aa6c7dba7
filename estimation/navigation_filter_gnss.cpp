// Positions, velocities and headings of the receiver: what is believed of them.
#include <algorithm>
#include <cmath>

#include "estimation/chi_square.hpp"
#include "estimation/navigation_filter.hpp"

namespace kawara::estimation {
namespace {

/// Wander of slow states, per sqrt(s).
constexpr double kTimeOffsetWander = 2.0e-5;
constexpr double kScaleWander = 2.0e-4;
constexpr double kTurnScaleWander = 2.0e-3;
constexpr double kResetTwice = 60.0;  // s between resets that say the heading is wrong
constexpr double kGravity = 9.8;

double Square(double v) { return v * v; }

}  // namespace

void NavigationFilter::FuseFix(const core::GnssFix& fix, double shift_s) {
  if (fix.has_position) FusePosition(fix, shift_s);
  if (fix.has_velocity) {
    const MeasurementRows rows = GnssVelocityRows(state(), Motion(), fix, shift_s, *config_);
    Offer(Source::kVelocity, rows, config_->trust.velocity_gate);
    last_velocity_ = state().stamp;
    gnss_speed_mps_ = fix.velocity_enu_mps.head<2>().norm();
    gnss_speed_limit_mps_ = std::max(0.06, 1.5 * fix.velocity_sd_enu_mps.head<2>().maxCoeff());
  }
  if (fix.has_heading) {
    Offer(Source::kHeading, HeadingRows(state(), fix.heading_rad, config_->two_antenna_sd_rad),
          ChiSquareOneOf1000(1));
  }
}

void NavigationFilter::AgePosition(const core::GnssFix& fix, GnssGrade grade) {
  const ColouredShare share = ShareOf(grade, config_->gnss);
  const Eigen::Vector3d variance = Square(share.coloured) * StatedVarianceNed(fix, config_->gnss);
  const double dt_s = SecondsSince(last_coloured_);
  last_coloured_ = state().stamp;
  if (!coloured_set_ || grade != coloured_grade_) {
    // Ambiguities were fixed or lost: what the error was says nothing of what it is.
    coloured_set_ = true;
    coloured_grade_ = grade;
    filter_.SetColoured(Eigen::Vector3d::Zero());
    filter_.Forget(kGnssColoured, variance);
  } else {
    filter_.Decay(kGnssColoured, {variance.data(), 3}, dt_s, share.time_s);
  }
  const double seconds = std::min(dt_s, 10.0);
  if (config_->time_offset_sd_s > 0.0) {
    filter_.Doubt(kTimeOffset, Square(kTimeOffsetWander) * seconds);
  }
  filter_.Doubt(kSpeedScale, Square(kScaleWander) * seconds);
  filter_.Doubt(kTurnScale, Square(kTurnScaleWander) * seconds);
  filter_.Doubt(kMountYaw, Square(0.1 * kScaleWander) * seconds);
  filter_.Doubt(kMountPitch, Square(kScaleWander) * seconds);
}

void NavigationFilter::FusePosition(const core::GnssFix& fix, double shift_s) {
  const GnssGrade grade = GradeOf(fix.rtk);
  const Source source = grade == GnssGrade::kFixed   ? Source::kFixed
                        : grade == GnssGrade::kFloat ? Source::kFloat
                                                     : Source::kCode;
  // The grade's errors are judged without disturbing those of the grade that is believed.
  const ErrorStateFilter undisturbed = filter_;
  const std::uint64_t tape_end = filter_.tape() != nullptr ? filter_.tape()->end() : 0;
  const core::GpsTime aged = last_coloured_;
  const GnssGrade believed = coloured_grade_;
  const bool was_set = coloured_set_;
  AgePosition(fix, grade);
  MeasurementRows rows = PositionRows(state(), Motion(), fix, shift_s, *config_);
  Innovation innovation = filter_.Predict(rows);

  auto& counts = stats_.source[static_cast<std::size_t>(source)];
  ++counts.offered;
  FixTrust::Verdict verdict = FixTrust::Verdict::kUse;
  if (hypothesis_) {
    log_likelihood_ += std::max(-kLikelihoodCap, innovation.LogLikelihood());
  } else {
    const bool refused_before = trust_.refusing(grade);
    const bool drifted = SecondsSince(last_position_) > config_->trust.outage_s &&
                         SecondsSince(last_speed_used_) > 1.0 && !holding_;
    verdict = trust_.Judge(state().stamp, grade, innovation.residual, innovation.nis, drifted,
                           config_->trust);
    if (!refused_before && trust_.refusing(grade)) ++stats_.wrong_fix_episodes;
  }
  refused_last_ = verdict == FixTrust::Verdict::kRefuse;
  if (verdict == FixTrust::Verdict::kRefuse) {
    ++counts.rejected;
    filter_ = undisturbed;
    if (filter_.tape() != nullptr) filter_.tape()->Rewind(tape_end);
    last_coloured_ = aged;
    coloured_grade_ = believed;
    coloured_set_ = was_set;
    return;
  }
  if (verdict == FixTrust::Verdict::kConcede) {
    Concede(innovation);
    rows = PositionRows(state(), Motion(), fix, shift_s, *config_);
    innovation = filter_.Predict(rows);
  }
  Use(source, rows, innovation);
  last_position_ = state().stamp;
  grade_ = grade;
}

void NavigationFilter::Concede(const Innovation& innovation) {
  ++stats_.resets;
  lost_ = lost_ || SecondsSince(last_reset_) < kResetTwice;
  last_reset_ = state().stamp;
  // As wrong as the position became since it was believed last, so may be what moved it there.
  const double seconds = std::clamp(SecondsSince(last_position_), 1.0, 60.0);
  const double miss_m = innovation.residual.norm();
  const double way_m = std::max(1.0, state().velocity_ned_mps.norm() * seconds);
  const double velocity = std::max(0.5, 2.0 * miss_m / seconds);
  const double level = std::clamp(2.0 * miss_m / (kGravity * seconds * seconds),
                                  0.5 * core::kRadFromDeg, 5.0 * core::kRadFromDeg);
  const double yaw = std::clamp(miss_m / way_m, 3.0 * core::kRadFromDeg, 20.0 * core::kRadFromDeg);
  filter_.Doubt(kPosition, innovation.residual.cwiseAbs2() + Eigen::Vector3d::Constant(1.0));
  filter_.Doubt(kVelocity, Eigen::Vector3d::Constant(Square(velocity)));
  filter_.Doubt(kAttitude, {Square(level), Square(level), Square(yaw)});
}

}  // namespace kawara::estimation
