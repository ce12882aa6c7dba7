#include "sim/radio_run.hpp"

#include <cstdio>

namespace kawara::sim {

core::Expected<RadioSummary> RunRadio(const RadioRunOptions& options,
                                      const std::atomic<bool>& stop) {
  for (const Fault& fault : options.faults) {
    if (!IsRadioFault(fault.kind)) {
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        std::string("fault ") + ToString(fault.kind) +
                            " is none of a radio: give it to kawara-sim drive or site");
    }
  }
  const core::MonoTime begin = core::MonoNow();
  const core::MonoTime end = options.duration_s
                                 ? begin + core::DurationFromSeconds(*options.duration_s)
                                 : core::MonoTime{};
  FaultPlan plan(options.faults);
  FaultOrderInbox orders;
  // Before the relay hears anything: LCM tries its bus when it opens it.
  const auto listener = FaultListener::Start(options.relay.robot_url, options.command_channel,
                                             begin, IsRadioFault, orders);
  if (!listener) return tl::unexpected(listener.error());
  auto relay = RadioRelay::Open(options.relay);
  if (!relay) return tl::unexpected(relay.error());
  std::printf("kawara-sim: radio between %s and %s\n", options.relay.robot_url.c_str(),
              options.relay.base_url.c_str());
  std::fflush(stdout);
  return (*relay)->Run(
      [&](core::MonoTime now) {
        const core::Duration t = now - begin;
        for (const FaultOrder& order : orders.Take(plan.faults().size())) {
          plan = Applied(plan, order, t);
        }
        return RadioFaults{.down = plan.Active(FaultKind::kRadioDown, t),
                           .loss = plan.Value(FaultKind::kRadioLoss, t),
                           .burst_loss = plan.Value(FaultKind::kRadioBurst, t),
                           .rate_bps = plan.Value(FaultKind::kRadioRate, t),
                           .delay_s = plan.Value(FaultKind::kRadioDelay, t)};
      },
      end, stop);
}

}  // namespace kawara::sim
