#include "onboard/epoch_scheduler.hpp"

#include <algorithm>
#include <chrono>

namespace kawara::onboard {
namespace {

constexpr core::Duration kSamePeriod = core::Milliseconds(4);
constexpr core::Duration kLongestPeriod = core::Seconds(2);
constexpr int kPeriodVotes = 3;
/// Epochs a stall is looked through for (bounds the real-time path).
constexpr int kMostPassed = 1000;

std::int64_t NearestIndex(core::GpsTime t, core::Duration period) {
  const std::int64_t p = period.count();
  return (t.ns() + p / 2) / p;
}

}  // namespace

EpochScheduler::EpochScheduler(const ScheduleConfig& config) : config_(config) {}

void EpochScheduler::OnFix(core::GpsTime epoch, const core::Geodetic* position) {
  if (last_fix_.IsSet() && epoch > last_fix_) {
    const core::Duration difference = epoch - last_fix_;
    if (std::chrono::abs(difference - candidate_) <= kSamePeriod) {
      if (++candidate_count_ >= kPeriodVotes && difference <= kLongestPeriod) {
        // Whole milliseconds: receivers round their epochs, the rounding must not move the phase.
        period_ = std::chrono::round<std::chrono::milliseconds>(candidate_);
      }
    } else {
      candidate_ = difference;
      candidate_count_ = 1;
    }
  }
  last_fix_ = epoch;
  if (position == nullptr) return;
  if (last_position_) {
    const Eigen::Vector3d step =
        core::EcefFromGeodetic(*position) - core::EcefFromGeodetic(*last_position_);
    // Below the noise of a standing receiver nothing is added: a parked robot does not take
    // pictures by jitter.
    if (step.norm() < 0.05) return;
    gone_m_ += step.norm();
  }
  last_position_ = *position;
}

std::optional<PictureReason> EpochScheduler::WantedAt(std::int64_t epoch_index) const {
  if (requested_) return PictureReason::kCommand;
  if (config_.every_m > 0.0 && gone_m_ >= config_.every_m) return PictureReason::kDistance;
  if (config_.every_epochs > 0 && epoch_index % config_.every_epochs == 0) {
    return PictureReason::kEveryEpochs;
  }
  return std::nullopt;
}

void EpochScheduler::Plan(core::MonoTime now, const estimation::GpsTimeline& timeline) {
  if (period_.count() <= 0 || !last_fix_.IsSet()) return PlanFreeRunning(now);
  const core::Duration lead = core::DurationFromSeconds(config_.trigger_lead_s);
  if (!timeline.valid()) return PlanFreeRunning(now);
  // One epoch at a time, decided as soon as the one before it is past: distance and commands count
  // until then.
  const core::Duration phase(last_fix_.ns() % period_.count());
  const auto next = timeline.NextEpoch(now, period_, phase, lead);
  if (!next) return PlanFreeRunning(now);
  const core::GpsTime epoch = next->gps;
  if (epoch <= last_planned_ + period_ / 2) return;
  CountPassed(epoch);
  const std::optional<PictureReason> reason = WantedAt(NearestIndex(epoch, period_));
  if (!reason) {
    last_planned_ = epoch;  // looked at and left out
    return;
  }
  next_ = PlannedExposure{epoch, next->mono - lead, *reason};
}

/// Wanted epochs between the last one decided and `next`: nobody called in time.
void EpochScheduler::CountPassed(core::GpsTime next) {
  if (!last_planned_.IsSet()) return;
  core::GpsTime passed = last_planned_ + period_;
  for (int i = 0; i < kMostPassed && passed + period_ / 2 < next; ++i, passed += period_) {
    if (WantedAt(NearestIndex(passed, period_))) ++skipped_;
  }
}

void EpochScheduler::PlanFreeRunning(core::MonoTime now) {
  if (config_.free_run_period_s <= 0.0) return;
  if (now - first_call_ < core::DurationFromSeconds(config_.free_run_after_s)) return;
  const core::Duration period = core::DurationFromSeconds(config_.free_run_period_s);
  next_ = PlannedExposure{{}, std::max(now, last_fired_ + period), PictureReason::kFreeRunning};
}

std::optional<PlannedExposure> EpochScheduler::Due(core::MonoTime now,
                                                   const estimation::GpsTimeline& timeline) {
  if (!first_call_.IsSet()) first_call_ = now;
  if (!next_) Plan(now, timeline);
  if (!next_ || next_->fire_at > now) return std::nullopt;
  const PlannedExposure due = *next_;
  next_.reset();
  if (due.epoch.IsSet()) last_planned_ = due.epoch;
  if (now - due.fire_at > kTooLate) {
    ++skipped_;
    return std::nullopt;
  }
  last_fired_ = now;
  gone_m_ = 0.0;
  requested_ = false;
  return due;
}

core::MonoTime EpochScheduler::NextDeadline(core::MonoTime now) const {
  const core::MonoTime idle = now + core::Milliseconds(20);
  return next_ ? std::min(next_->fire_at, idle) : idle;
}

}  // namespace kawara::onboard
