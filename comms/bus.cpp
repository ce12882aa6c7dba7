#include "comms/bus.hpp"

#include <algorithm>

#include "comms/event_log.hpp"

namespace kawara::comms {

void Bus::CountBadMessage(std::string_view channel, const core::Error& error) {
  ++bad_messages_;
  last_bad_message_ = std::string(channel) + ": " + error.message;
}

bool IsChannelName(std::string_view channel) {
  return !channel.empty() && channel.size() <= kLogMaxChannelBytes &&
         std::ranges::all_of(channel, [](char c) { return c >= 0x20 && c < 0x7f; });
}

}  // namespace kawara::comms
