#pragma once
#include <atomic>
#include <string_view>
#include <thread>

#include "core/counters.hpp"
#include "core/events.hpp"
#include "drivers/pps.hpp"
#include "onboard/input_inbox.hpp"

namespace kawara::onboard {

/// The pulses' thread: waits for edges and posts each to the core with its stamp. Says once when
/// the source is gone and once when it is back.
class PpsReader {
 public:
  PpsReader(drivers::PpsSource& source, InputInbox& inbox, core::Counters& counters);
  ~PpsReader();  ///< Stop()
  PpsReader(const PpsReader&) = delete;
  PpsReader& operator=(const PpsReader&) = delete;
  void Stop();

 private:
  void Run();
  void Tell(bool open, core::Severity severity, std::string_view text);

  drivers::PpsSource& source_;
  InputInbox& inbox_;
  core::Counter& edges_;
  bool was_up_ = false;
  bool was_told_ = false;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kawara::onboard
