#include "onboard/system_clock_reference.hpp"

#include <utility>

#include "drivers/pps_device.hpp"

namespace kawara::onboard {

SystemClockReference::SystemClockReference(int ntp_shm_unit, core::Counters& counters, Tell tell)
    : shm_(ntp_shm_unit),
      tell_(std::move(tell)),
      offered_(counters.Register("system_clock.offered")),
      off_us_(counters.Register("system_clock.off_us")) {}

void SystemClockReference::OnClock(const estimation::ClockStatus& clock) {
  using estimation::ClockSource;
  const bool received = clock.source == ClockSource::kEnvelope || clock.source == ClockSource::kPps;
  if (!received || !(clock.sigma_s < kWorst_s)) return;
  drivers::ClockComparison comparison;
  comparison.utc = core::ToUtc(core::GpsTime::FromNs(clock.stream.ns()));
  comparison.realtime_ns = clock.mono.ns() + drivers::ClockPair::Read().offset_ns();
  comparison.sigma_s = clock.sigma_s;
  const auto told = shm_.Tell(comparison);
  const State state = told ? State::kTold : State::kFails;
  if (state != std::exchange(state_, state)) {
    tell_(told ? EventNote{core::Severity::kInfo, "system_clock.offered",
                           "GPS time is offered to the computer's time service"}
               : EventNote{core::Severity::kWarnLow, "system_clock.refused", told.error().message});
  }
  if (!told) return;
  offered_.Add();
  off_us_.Set((comparison.realtime_ns - comparison.utc.ns()) / 1000);
}

}  // namespace kawara::onboard
