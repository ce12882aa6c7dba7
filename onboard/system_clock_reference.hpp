#pragma once
#include <functional>

#include "core/counters.hpp"
#include "drivers/ntp_shm.hpp"
#include "estimation/clock_types.hpp"
#include "onboard/input.hpp"

namespace kawara::onboard {

/// Offers the robot's GPS time to the service that keeps the computer's clock (chronyd, ntpd). The
/// robot itself never needs that clock and never sets it. Only time that rests on the receiver just
/// now is offered; how well it is known is told with it. Pump's thread only. Counters:
/// system_clock.offered, and .off_us: the computer's clock less the true time, as told last.
class SystemClockReference {
 public:
  /// `tell`: once when it begins to fail, with the cure, and once when it works (again).
  using Tell = std::function<void(const EventNote&)>;
  SystemClockReference(int ntp_shm_unit, core::Counters& counters, Tell tell);

  void OnClock(const estimation::ClockStatus& clock);

  /// Time worse than this is no reference.
  static constexpr double kWorst_s = 0.2;

 private:
  enum class State : std::uint8_t { kNew, kTold, kFails };
  drivers::NtpShm shm_;
  Tell tell_;
  State state_ = State::kNew;
  core::Counter& offered_;
  core::Counter& off_us_;
};

}  // namespace kawara::onboard
