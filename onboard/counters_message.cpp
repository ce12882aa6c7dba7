#include "onboard/counters_message.hpp"

#include <kawara/counters_t.hpp>
#include <utility>

#include "comms/codec.hpp"
#include "core/check.hpp"

namespace kawara::onboard {

std::vector<std::uint8_t> CountersMessage(const core::Counters& counters, core::MonoTime now) {
  counters_t message;
  message.mono_ns = now.ns();
  message.program = "kawara-onboard";
  for (const core::Counters::Value& counter : counters.Snapshot()) {
    message.name.push_back(counter.name);
    message.value.push_back(counter.value);
  }
  message.n = static_cast<std::int32_t>(message.name.size());
  auto bytes = comms::Encode(message);
  CORE_CHECK(bytes.has_value());  // arrays are as long as their count says
  return std::move(*bytes);
}

}  // namespace kawara::onboard
