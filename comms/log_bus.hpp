#pragma once
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "comms/bus.hpp"
#include "comms/event_log_reader.hpp"

namespace kawara::comms {

struct LogBusOptions {
  /// 0: as fast as the handlers take it. 1: at the pace it was recorded, 10: ten times that.
  double pace = 0.0;
  /// Where the program's own messages go while it works from a log, e.g. into another log. Null:
  /// nowhere.
  Handler published{};
};

/// Plays a recording to its subscribers, in this thread, in recorded order, losing none: the same
/// log gives the same calls every time. One HandleFor delivers at most 64 events, so that a caller
/// can look at other things.
class LogBus : public Bus {
 public:
  explicit LogBus(EventLogReader reader, LogBusOptions options = {});

  /// Not heard by this bus's subscribers: what a program said when the log was made is in the log
  /// already.
  core::Expected<void> Publish(std::string_view channel,
                               std::span<const std::uint8_t> data) override;
  core::Expected<void> Subscribe(const std::string& channel, Handler handler) override;
  core::Expected<int> HandleFor(core::Duration timeout) override;
  bool AtEnd() const override { return at_end_; }

  const EventLogReader& reader() const { return reader_; }

 private:
  struct Subscription {
    std::regex pattern;
    Handler handler;
  };
  bool WaitUntilDue(const LogEvent& event, core::MonoTime deadline);
  int Deliver(const LogEvent& event);
  const std::vector<std::size_t>& Matching(std::string_view channel);

  EventLogReader reader_;
  LogBusOptions options_;
  std::vector<Subscription> subscriptions_;
  std::map<std::string, std::vector<std::size_t>, std::less<>> matching_;
  std::optional<LogEvent> waiting_;  ///< read, but not due yet
  core::MonoTime start_mono_;
  std::int64_t start_time_utc_us_ = 0;
  std::int64_t now_utc_us_ = 0;
  std::int64_t published_ = 0;
  bool at_end_ = false;
};

}  // namespace kawara::comms
