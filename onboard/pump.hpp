#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "comms/bus.hpp"
#include "core/counters.hpp"
#include "onboard/correction_source.hpp"
#include "onboard/frame_table.hpp"
#include "onboard/heartbeat.hpp"
#include "onboard/input_inbox.hpp"
#include "onboard/message_sink.hpp"
#include "onboard/outlet.hpp"
#include "onboard/output_ring.hpp"
#include "onboard/picture_worker.hpp"
#include "onboard/system_clock_reference.hpp"

namespace kawara::onboard {

/// The thread between the real-time loop and the rest of the world: what the core says becomes
/// messages on the bus and in the log, picture orders go to the worker; commands and corrections
/// from the bus go to the core; once a second the counters are published.
class Pump {
 public:
  struct Parts {
    OutputRing& output;
    InputInbox& inbox;
    FrameTable& frames;
    Outlet& outlet;
    comms::Bus& bus;
    core::Counters& counters;
    PictureWorker* pictures = nullptr;  ///< null: no camera
    CorrectionSource& corrections;
    SystemClockReference* system_clock = nullptr;  ///< null: nobody wants to know the time
    bool camera_runs_freely =
        false;  ///< frames that no trigger asked for are logged without pixels
  };
  /// Subscribes to COMMAND for `robot`, and to CORRECTIONS if `corrections_from_bus`.
  Pump(const Parts& parts, RobotConfig robot, bool corrections_from_bus);
  ~Pump();  ///< Stop()
  Pump(const Pump&) = delete;
  Pump& operator=(const Pump&) = delete;

  void Start();
  /// Delivers what the core has said until now, then ends.
  void Stop();
  const Heartbeat& heart() const { return heart_; }

 private:
  class Sink;
  void Run();
  void Deliver();
  void Subscribe(bool corrections_from_bus);
  void EverySecond(core::MonoTime now);
  void PostSystemClock(core::MonoTime now);

  Parts parts_;
  RobotConfig robot_;
  std::int64_t last_command_ = -1;
  core::MonoTime next_second_;
  core::MonoTime next_system_clock_;
  Heartbeat heart_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kawara::onboard
