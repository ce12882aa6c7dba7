#pragma once
#include <string>
#include <utility>

#include "comms/bus.hpp"
#include "comms/codec.hpp"

namespace kawara::comms {

/// Publishes an LCM message object. Errors: those of Encode and Bus::Publish.
template <class T>
[[nodiscard]] core::Expected<void> Publish(Bus& bus, std::string_view channel, const T& message) {
  return Encode(message).and_then(
      [&](const std::vector<std::uint8_t>& bytes) { return bus.Publish(channel, bytes); });
}

/// Calls handler(const T&, const MessageMeta&) for every message on `channel` (name or regular
/// expression) that is a complete T. Anything else (other type, cut, hostile lengths) is dropped
/// and counted in bus.bad_messages().
template <class T, class F>
[[nodiscard]] core::Expected<void> Subscribe(Bus& bus, const std::string& channel, F handler) {
  return bus.Subscribe(channel, [&bus, handler = std::move(handler)](
                                    std::string_view name, std::span<const std::uint8_t> data,
                                    const MessageMeta& meta) mutable {
    core::Expected<T> message = Decode<T>(data);
    if (message) {
      handler(std::as_const(*message), meta);
    } else {
      bus.CountBadMessage(name, message.error());
    }
  });
}

}  // namespace kawara::comms
