#include "estimation/gps_timeline.hpp"

#include <cmath>

namespace kawara::estimation {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

std::int64_t FloorMultiple(std::int64_t value, std::int64_t period) {
  const std::int64_t rest = value % period;
  return value - (rest < 0 ? rest + period : rest);
}

}  // namespace

GpsTimeline::GpsTimeline(const GpsTimelineConfig& config)
    : config_(config), envelope_(config.envelope), pps_(config.pps) {}

EnvelopeClock::Result GpsTimeline::AddEpoch(core::GpsTime epoch, core::MonoTime arrival) {
  return envelope_.Add(StreamTime::FromNs(epoch.ns()), arrival);
}

PpsClock::Result GpsTimeline::AddPulse(core::MonoTime edge) {
  return pps_.AddPulse(edge, LabelOf(edge));
}

void GpsTimeline::AddPulseLabel(core::GpsTime second, core::MonoTime arrival) {
  pps_.AddLabel(second, arrival);
}

std::optional<core::GpsTime> GpsTimeline::LabelOf(core::MonoTime edge) const {
  if (!envelope_.valid()) return std::nullopt;
  // The envelope with its configured latency taken out again: an instant `minimal latency` before
  // the truth. The truth then lies within [early, early + max_min_latency], give or take what the
  // envelope itself does not know.
  const EnvelopeConfig& e = config_.envelope;
  const Aligned<StreamTime> mapped = envelope_.ToStream(edge);
  const double edge_var =
      mapped.sigma_s * mapped.sigma_s - e.min_latency_sigma_s * e.min_latency_sigma_s;
  const double margin_s = 4.0 * std::sqrt(std::max(0.0, edge_var)) + 1e-3;
  const core::Duration margin = core::DurationFromSeconds(margin_s);
  const core::GpsTime early =
      core::GpsTime::FromNs(mapped.time.ns()) - core::DurationFromSeconds(e.min_latency_s);
  const core::GpsTime from = early - margin;
  const core::GpsTime to = early + core::DurationFromSeconds(config_.max_min_latency_s) + margin;
  const std::int64_t last = FloorMultiple(to.ns(), kNsPerS);
  const bool exactly_one = last >= from.ns() && last - kNsPerS < from.ns();
  return exactly_one ? std::optional(core::GpsTime::FromNs(last)) : std::nullopt;
}

bool GpsTimeline::PulsesRule(core::MonoTime at) const {
  if (!pps_.locked()) return false;
  if (!envelope_.valid()) return true;
  return pps_.ToGps(at).sigma_s <= envelope_.ToStream(at).sigma_s;
}

Aligned<core::GpsTime> GpsTimeline::ToGps(core::MonoTime t) const {
  if (PulsesRule(t)) return pps_.ToGps(t);
  const Aligned<StreamTime> stream = envelope_.ToStream(t);
  return {core::GpsTime::FromNs(stream.time.ns()), stream.sigma_s};
}

Aligned<core::MonoTime> GpsTimeline::ToMono(core::GpsTime t) const {
  const Aligned<core::MonoTime> by_envelope = envelope_.ToMono(StreamTime::FromNs(t.ns()));
  if (!pps_.locked()) return by_envelope;
  // The same choice as ToGps makes at that instant, so that the two are inverse to each other.
  const Aligned<core::MonoTime> by_pulses = pps_.ToMono(t);
  return PulsesRule(by_pulses.time) ? by_pulses : by_envelope;
}

std::optional<GpsTimeline::Epoch> GpsTimeline::NextEpoch(core::MonoTime now, core::Duration period,
                                                         core::Duration phase,
                                                         core::Duration lead) const {
  if (!valid() || period.count() <= 0) return std::nullopt;
  const core::GpsTime earliest = ToGps(now + lead).time;
  const std::int64_t before = FloorMultiple(earliest.ns() - phase.count(), period.count());
  core::GpsTime next = core::GpsTime::FromNs(before + phase.count());
  if (next < earliest) next += period;
  Aligned<core::MonoTime> mono = ToMono(next);
  if (mono.time < now + lead) {  // rounding of the conversions by a nanosecond or so
    next += period;
    mono = ToMono(next);
  }
  return Epoch{next, mono.time, mono.sigma_s};
}

ClockStatus GpsTimeline::Status(core::MonoTime now) const {
  const ClockStatus pps = pps_.Status(now);
  const ClockStatus envelope = envelope_.Status(now);
  ClockStatus status = PulsesRule(now) ? pps : envelope;
  status.steps = pps.steps + envelope.steps;
  status.outliers = pps.outliers + envelope.outliers;
  return status;
}

}  // namespace kawara::estimation
