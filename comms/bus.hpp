#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::comms {

/// What the bus knows of a message besides its bytes.
struct MessageMeta {
  std::int64_t number = 0;  ///< log: event number; live: messages handled before this one
  /// log: the recorded time; live: when this process handled it. Microseconds since 1970 UTC by the
  /// system clock, for people and file names only: every message carries its own stamps (GPS,
  /// monotonic).
  std::int64_t time_utc_us = 0;
};

/// Runs inside Bus::HandleFor, on its thread. The bytes are valid during the call only. Must not
/// throw.
using Handler = std::function<void(std::string_view channel, std::span<const std::uint8_t> data,
                                   const MessageMeta& meta)>;

/// Messages as bytes on named channels. LcmBus (live) and LogBus (a recording) are interchangeable:
/// a program never asks which one it has. Typed publishing and subscribing is in
/// comms/typed_bus.hpp. Publish may be called from any thread (LcmBus: it takes a lock and may
/// block in the kernel, so never from a real-time thread). Subscribe before the first HandleFor,
/// and both from one thread.
class Bus {
 public:
  Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  virtual ~Bus() = default;

  /// Errors: kInvalidArgument (channel empty, over 63 characters or not printable), kIo.
  [[nodiscard]] virtual core::Expected<void> Publish(std::string_view channel,
                                                     std::span<const std::uint8_t> data) = 0;
  /// `channel` is a name or a regular expression that must match the whole name. Errors:
  /// kInvalidArgument.
  [[nodiscard]] virtual core::Expected<void> Subscribe(const std::string& channel,
                                                       Handler handler) = 0;
  /// Waits up to `timeout` for the first message and hands over what is there. Returns how many: 0
  /// is "nothing came" or AtEnd(). Errors: kIo.
  [[nodiscard]] virtual core::Expected<int> HandleFor(core::Duration timeout) = 0;
  /// True once a recording has no more messages. A live bus never ends.
  virtual bool AtEnd() const { return false; }
  /// Readable when HandleFor would not wait, for poll(); -1 where there is none (a recording is
  /// always ready).
  virtual int fd() const { return -1; }

  /// Messages that did not decode as their subscriber expected; counted by typed Subscribe.
  /// Handling thread only.
  std::uint64_t bad_messages() const { return bad_messages_; }
  /// One line about the latest of them, empty if none: "POSE: 12 bytes, kawara.pose_t has 241".
  const std::string& last_bad_message() const { return last_bad_message_; }
  void CountBadMessage(std::string_view channel, const core::Error& error);

 private:
  std::uint64_t bad_messages_ = 0;
  std::string last_bad_message_;
};

/// LCM's rule for a channel name: 1 to 63 printable characters.
bool IsChannelName(std::string_view channel);

}  // namespace kawara::comms
