#pragma once
#include <atomic>
#include <thread>

#include "core/counters.hpp"
#include "drivers/pps.hpp"
#include "onboard/input_inbox.hpp"
#include "onboard/port_teller.hpp"

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

  drivers::PpsSource& source_;
  InputInbox& inbox_;
  PortTeller teller_;
  core::Counter& edges_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kawara::onboard
