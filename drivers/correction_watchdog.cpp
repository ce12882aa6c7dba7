#include "drivers/correction_watchdog.hpp"

#include <algorithm>
#include <variant>

namespace kawara::drivers {
namespace {

bool IsCodeDifferential(std::uint8_t type) {
  return type == 1 || type == 9 || type == 31 || type == 34;
}

}  // namespace

const char* ToString(CorrectionFormat f) {
  switch (f) {
    case CorrectionFormat::kRtcm2:
      return "RTCM2";
    case CorrectionFormat::kRtcm3:
      return "RTCM3";
    case CorrectionFormat::kRaw:
      return "raw";
  }
  return "?";
}

CorrectionWatchdog::CorrectionWatchdog(const CorrectionWatchdogConfig& config, core::Events& events)
    : config_(config), events_(events) {}

void CorrectionWatchdog::Start(core::MonoTime now) { started_ = now; }

void CorrectionWatchdog::OnMessage(core::MonoTime now, const Rtcm3Message& m) {
  Count(now, CorrectionFormat::kRtcm3, m.type, m.length + kRtcm3HeaderBytes + kRtcm3CrcBytes);
  if (const auto* observations = std::get_if<Rtcm3Observations>(&m.body)) {
    if (observations->satellites > 0) OnObservations(now, true);
  } else if (const auto* station = std::get_if<Rtcm3Station>(&m.body)) {
    OnBase(now, m.station, station->ecef_m);
  }
}

void CorrectionWatchdog::OnMessage(core::MonoTime now, const Rtcm2Message& m) {
  Count(now, CorrectionFormat::kRtcm2, m.type, (std::size_t{m.data_words} + 2) * 5);
  constexpr std::uint8_t kDoNotUse = 7;
  if (m.health == kDoNotUse) return;
  if (const auto* observations = std::get_if<Rtcm2Observations>(&m.body)) {
    if (observations->count > 0) OnObservations(now, true);
  } else if (IsCodeDifferential(m.type) && config_.accept_code_differential) {
    OnObservations(now, false);
  } else if (const auto* station = std::get_if<Rtcm2Station>(&m.body)) {
    if (station->is_reference_point) return OnBase(now, m.station, station->ecef_m);
    // Message 3 says again in centimetres what 22 has made finer: that is no move.
    const bool same = base_ && base_->station == m.station && coarse_m_ == station->ecef_m;
    coarse_m_ = station->ecef_m;
    coarse_station_ = m.station;
    OnBase(now, m.station, same ? base_->ecef_m : station->ecef_m);
  } else if (const auto* offset = std::get_if<Rtcm2StationOffset>(&m.body)) {
    if (coarse_station_ == m.station) OnBase(now, m.station, coarse_m_ + offset->l1_m);
  }
}

void CorrectionWatchdog::OnRefused(core::MonoTime now, CorrectionFormat format, std::uint16_t type,
                                   std::size_t bytes) {
  Count(now, format, type, bytes);
}

void CorrectionWatchdog::Tick(core::MonoTime now) {
  if (!started_.IsSet()) started_ = now;
  const core::Duration shown = now - std::max(started_, usable_at_);
  if (alarm_ || shown < config_.alarm_age) return;
  alarm_ = true;
  alarm_since_ = now - shown;
  ++alarms_;
  core::EventText text("no usable corrections for ");
  text.Append(core::ToSeconds(shown), 1).Append(" s: ");
  if (types_used_ == 0) {
    text.Append("nothing came at all; check the source");
  } else if (!has_observations_ || now - observations_at_ >= config_.alarm_age) {
    text.Append(has_observations_
                    ? "observations stopped; check radio or caster"
                    : "messages come, but no observations in a format the receiver takes");
  } else {
    text.Append(base_ ? "the base's position is too old"
                      : "the base's position never came (1005/1006 or 3)");
  }
  events_.WarnHigh(now, "corrections.stale", text);
}

std::optional<core::Duration> CorrectionWatchdog::Age(core::MonoTime now) const {
  if (!has_observations_) return std::nullopt;
  if (needs_base_ && (!base_ || now - base_->last > config_.base_position_max_age))
    return std::nullopt;
  return now - observations_at_;
}

void CorrectionWatchdog::Count(core::MonoTime now, CorrectionFormat format, std::uint16_t type,
                               std::size_t bytes) {
  std::size_t i = 0;
  while (i < types_used_ && (types_[i].format != format || types_[i].type != type)) ++i;
  if (i == types_used_) {
    if (types_used_ < types_.size()) {
      ++types_used_;
    } else {
      --i;
    }
    if (types_[i].count == 0) {
      types_[i].format = format;
      types_[i].type = type;
    }
  }
  CorrectionTypeStats& s = types_[i];
  if (s.count > 0) {
    constexpr double kWeight = 1.0 / 8.0;
    const double interval_s = core::ToSeconds(now - s.last);
    s.interval_s = s.count == 1 ? interval_s : s.interval_s + kWeight * (interval_s - s.interval_s);
  }
  ++s.count;
  s.bytes += bytes;
  s.last = now;
}

void CorrectionWatchdog::OnObservations(core::MonoTime now, bool needs_base) {
  has_observations_ = true;
  observations_at_ = now;
  needs_base_ = needs_base;
  NoteUsable(now);
}

void CorrectionWatchdog::OnBase(core::MonoTime now, std::uint16_t station,
                                const Eigen::Vector3d& ecef_m) {
  if (base_) {
    const double moved_m = (ecef_m - base_->ecef_m).norm();
    if (station != base_->station || moved_m > config_.base_moved_m) {
      ++base_moves_;
      core::EventText text("base ");
      text.Append(base_->station);
      if (station != base_->station) text.Append(" replaced by base ").Append(station).Append(",");
      text.Append(" moved by ").Append(moved_m, 3).Append(" m: positions will jump by that");
      events_.WarnHigh(now, "corrections.base_moved", text);
    }
  }
  base_ = Base{station, ecef_m, now};
  NoteUsable(now);
}

void CorrectionWatchdog::NoteUsable(core::MonoTime now) {
  if (!Age(now)) return;
  usable_at_ = observations_at_;
  if (!alarm_ || now - usable_at_ >= config_.alarm_age) return;
  alarm_ = false;
  core::EventText text("usable corrections again after ");
  text.Append(core::ToSeconds(now - alarm_since_), 1).Append(" s");
  events_.Info(now, "corrections.recovered", text);
}

}  // namespace kawara::drivers
