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

  /// Failures are counted as "bus.not_sent" and "recorder.refused".
  Outlet(comms::Bus& bus, core::Counters& counters);
  /// From now on Send() records too. Before any other thread calls Send(); `recorder` stays.
  void RecordTo(comms::Recorder& recorder) { recorder_ = &recorder; }

  void Send(std::string_view channel, std::span<const std::uint8_t> bytes, Reach reach);
  /// What the recorder has to tell, live, in the bytes in which it stands in the log. This is what
  /// the recorder's own thread may call, also before RecordTo().
  void Publish(const comms::RecorderEvent& event);

 private:
  comms::Bus& bus_;
  comms::Recorder* recorder_ = nullptr;  ///< null: nothing is recorded
  core::Counter& not_sent_;
  core::Counter& not_recorded_;
};

/// Microseconds since 1970 UTC by the computer's clock, for the time column of logs.
std::int64_t WallClockUs();

}  // namespace kawara::onboard
