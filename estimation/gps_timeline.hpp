#pragma once
#include <optional>

#include "estimation/envelope_clock.hpp"
#include "estimation/pps_clock.hpp"

namespace kawara::estimation {

struct GpsTimelineConfig {
  EnvelopeConfig envelope;
  PpsConfig pps;
  /// The receiver's smallest epoch-to-arrival delay lies below this. A pulse is labelled from
  /// epochs only if that leaves exactly one second possible; must stay below 1 s minus the
  /// uncertainty to be of use.
  double max_min_latency_s = 0.7;
};

/// The one GPS time line of the robot: from GNSS epochs by earliest arrival, from pulses where
/// there are any. Both run side by side; the pulses rule while they are alive or still better than
/// the envelope in hold-over. CLOCK_MONOTONIC is the other side; the system clock is never used, so
/// setting it changes nothing. Real-time safe, deterministic, fixed memory. One thread.
class GpsTimeline {
 public:
  explicit GpsTimeline(const GpsTimelineConfig& config = {});

  /// Every GNSS epoch: the instant of validity and the arrival of its first byte.
  EnvelopeClock::Result AddEpoch(core::GpsTime epoch, core::MonoTime arrival);
  /// Every pulse (edge stamp).
  PpsClock::Result AddPulse(core::MonoTime edge);
  /// A message naming the second of the pulse before it (PTT).
  void AddPulseLabel(core::GpsTime second, core::MonoTime arrival);

  /// Something is known. The conversions are meaningful only then.
  bool valid() const { return pps_.locked() || envelope_.valid(); }
  Aligned<core::GpsTime> ToGps(core::MonoTime t) const;
  Aligned<core::MonoTime> ToMono(core::GpsTime t) const;

  /// The first GPS instant that is a multiple of `period` plus `phase` and comes at least `lead`
  /// after `now`.
  struct Epoch {
    core::GpsTime gps;
    core::MonoTime mono;
    double sigma_s = 0.0;
  };
  std::optional<Epoch> NextEpoch(core::MonoTime now, core::Duration period,
                                 core::Duration phase = core::Duration(0),
                                 core::Duration lead = core::Duration(0)) const;

  /// For the CLOCK message of stream "gps": the ruling source; steps and outliers of both.
  ClockStatus Status(core::MonoTime now) const;
  const EnvelopeClock& envelope() const { return envelope_; }
  const PpsClock& pps() const { return pps_; }

  /// The conversions at this instant rest on the pulses (in hold-over, too), not on the epochs'
  /// arrivals.
  bool PulsesRule(core::MonoTime at) const;

 private:
  std::optional<core::GpsTime> LabelOf(core::MonoTime edge) const;

  const GpsTimelineConfig config_;
  EnvelopeClock envelope_;
  PpsClock pps_;
};

}  // namespace kawara::estimation
