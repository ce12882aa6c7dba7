#pragma once
#include <functional>
#include <span>
#include <string_view>

#include "comms/bus.hpp"
#include "comms/recorder.hpp"
#include "core/counters.hpp"
#include "onboard/message_sink.hpp"

namespace kawara::onboard {

/// Where messages leave the program: onto the bus, into the log, or both. Any thread but the
/// real-time one.
class Outlet {
 public:
  using Reach = MessageSink::Reach;

  /// Either may be null. Failures are counted as "bus.not_sent" and "recorder.refused".
  Outlet(comms::Bus* bus, comms::Recorder* recorder, core::Counters& counters);

  void Send(std::string_view channel, std::span<const std::uint8_t> bytes, Reach reach);

 private:
  comms::Bus* bus_;
  comms::Recorder* recorder_;
  core::Counter& not_sent_;
  core::Counter& not_recorded_;
};

/// Microseconds since 1970 UTC by the computer's clock, for the time column of logs.
std::int64_t WallClockUs();

}  // namespace kawara::onboard
