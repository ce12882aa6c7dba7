#include "onboard/pulse_chain.hpp"

#include <chrono>

namespace kawara::onboard {
namespace {

/// From the first GPS time to a word about pulses that never came.
constexpr core::Duration kPatience = core::Seconds(30);
/// Edges farther from a second apart are of another rate, or of another edge between.
constexpr core::Duration kSecondTolerance = core::Milliseconds(50);

}  // namespace

PulseChain::PulseChain(const PpsSettings& settings, estimation::GpsTimeline& timeline,
                       core::Events& events)
    : wanted_(!settings.device.empty()), timeline_(timeline), events_(events) {}

void PulseChain::OnEdge(core::MonoTime edge, std::uint32_t sequence) {
  // Counted anew when whoever counts was started anew.
  if (last_sequence_ != 0 && sequence > last_sequence_)
    stats_.missing += sequence - last_sequence_ - 1;
  last_sequence_ = sequence;
  if (last_edge_.IsSet()) interval_ = edge - last_edge_;
  last_edge_ = edge;
  switch (timeline_.AddPulse(edge)) {
    case estimation::PpsClock::Result::kUsed:
    case estimation::PpsClock::Result::kStepped:
      ++stats_.used;
      break;
    case estimation::PpsClock::Result::kUnlabelled:
      ++stats_.waiting;
      break;
    case estimation::PpsClock::Result::kDouble:
    case estimation::PpsClock::Result::kOutlier:
      ++stats_.refused;
      break;
  }
}

PulseChain::Basis PulseChain::BasisAt(core::MonoTime now) const {
  if (!timeline_.PulsesRule(now)) return Basis::kArrivals;
  const bool alive = timeline_.pps().Status(now).source == estimation::ClockSource::kPps;
  return alive ? Basis::kPulses : Basis::kHoldover;
}

void PulseChain::Tick(core::MonoTime now) {
  if (!wanted_ || !timeline_.valid()) return;
  const Basis basis = BasisAt(now);
  if (basis_ == Basis::kNotYet && basis != Basis::kPulses) return ComplainOfNone(now);
  if (basis == basis_) return;
  basis_ = basis;
  Tell(now, basis);
}

void PulseChain::Tell(core::MonoTime now, Basis basis) {
  core::EventText text;
  const double sigma_us = timeline_.Status(now).sigma_s * 1e6;
  switch (basis) {
    case Basis::kPulses:
      text.Append("GPS time rests on the receiver's pulses, good to ")
          .Append(sigma_us, 0)
          .Append(" us");
      return events_.Info(now, "clock.pps", text);
    case Basis::kHoldover:
      text.Append("no pulse for ")
          .Append(core::ToSeconds(now - timeline_.pps().last_pulse()), 0)
          .Append(" s: GPS time is held over, good to ")
          .Append(sigma_us, 0)
          .Append(" us and getting worse");
      return events_.WarnLow(now, "clock.holdover", text);
    case Basis::kArrivals:
      text.Append("no pulses: GPS time rests on when the receiver's bytes arrive, good to ")
          .Append(sigma_us, 0)
          .Append(" us");
      return events_.WarnHigh(now, "clock.no_pps", text);
    case Basis::kNotYet:
      return;
  }
}

void PulseChain::ComplainOfNone(core::MonoTime now) {
  if (!waiting_since_.IsSet()) waiting_since_ = now;
  if (now - waiting_since_ < kPatience) return;
  waiting_since_ = now;
  core::EventText text("gps.pps.device is configured, but ");
  if (stats_.waiting + stats_.refused == 0) {
    text.Append("no pulse has come: cable, receiver's PPS setting, gps.pps.edge?");
  } else if (std::chrono::abs(interval_ - core::Seconds(1)) > kSecondTolerance) {
    text.Append("its pulses come ")
        .Append(core::ToSeconds(interval_), 3)
        .Append(" s apart, not one a second: the receiver's PPS setting?");
  } else {
    text.Append("its pulses do not fit the receiver's seconds");
  }
  events_.WarnHigh(now, "clock.no_pps", text);
}

}  // namespace kawara::onboard
