#include "onboard/outlet.hpp"

#include <chrono>

#include "comms/codec.hpp"

namespace kawara::onboard {

Outlet::Outlet(comms::Bus& bus, core::Counters& counters)
    : bus_(bus),
      not_sent_(counters.Register("bus.not_sent")),
      not_recorded_(counters.Register("recorder.refused")) {}

void Outlet::Send(std::string_view channel, std::span<const std::uint8_t> bytes, Reach reach) {
  // The log first: what the headquarters has seen must be in it.
  if (recorder_ != nullptr && !recorder_->Write(channel, bytes, WallClockUs())) not_recorded_.Add();
  if (reach == Reach::kLogOnly) return;
  if (!bus_.Publish(channel, bytes)) not_sent_.Add();
}

void Outlet::Publish(const comms::RecorderEvent& event) {
  const auto bytes = comms::Encode(comms::ToMessage(event));
  if (!bytes || !bus_.Publish("EVENT", *bytes)) not_sent_.Add();
}

std::int64_t WallClockUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace kawara::onboard
