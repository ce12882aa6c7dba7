#include "onboard/outlet.hpp"

#include <chrono>

namespace kawara::onboard {

Outlet::Outlet(comms::Bus* bus, comms::Recorder* recorder, core::Counters& counters)
    : bus_(bus),
      recorder_(recorder),
      not_sent_(counters.Register("bus.not_sent")),
      not_recorded_(counters.Register("recorder.refused")) {}

void Outlet::Send(std::string_view channel, std::span<const std::uint8_t> bytes, Reach reach) {
  // The log first: what the headquarters has seen must be in it.
  if (recorder_ != nullptr && !recorder_->Write(channel, bytes, WallClockUs())) not_recorded_.Add();
  if (reach == Reach::kLogOnly || bus_ == nullptr) return;
  if (!bus_->Publish(channel, bytes)) not_sent_.Add();
}

std::int64_t WallClockUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace kawara::onboard
