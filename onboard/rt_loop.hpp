#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "core/counters.hpp"
#include "drivers/camera.hpp"
#include "drivers/reconnecting_port.hpp"
#include "onboard/config.hpp"
#include "onboard/heartbeat.hpp"
#include "onboard/input_inbox.hpp"
#include "onboard/output_ring.hpp"
#include "onboard/robot_core.hpp"

namespace kawara::onboard {

/// Bytes on their way out to a port that cannot take them all at once. Fixed memory; what does not
/// fit is dropped whole and counted.
class PortWriter {
 public:
  explicit PortWriter(drivers::ReconnectingPort& port) : port_(port) {}
  void Add(core::MonoTime now, std::span<const std::uint8_t> bytes);
  void Flush(core::MonoTime now);
  void Clear() { size_ = 0; }
  bool pending() const { return size_ > 0; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  drivers::ReconnectingPort& port_;
  std::array<std::uint8_t, 8192> buffer_{};
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
};

/// The real-time loop: waits for the ports, the inbox or the next trigger, makes numbered inputs of
/// what comes, runs the core on them and lets it act (trigger, ports). Everything else leaves
/// through the OutputRing. One thread of its own, SCHED_FIFO if granted; after Start() it neither
/// allocates, nor locks, nor touches a file.
class RtLoop {
 public:
  /// All references must outlive the loop. `camera` may be null.
  RtLoop(const OnboardConfig& config, core::Counters& counters, InputInbox& inbox,
         OutputRing& output, drivers::Camera* camera);
  ~RtLoop();  ///< Stop()
  RtLoop(const RtLoop&) = delete;
  RtLoop& operator=(const RtLoop&) = delete;

  void Start();
  void Stop();
  const Heartbeat& heart() const { return heart_; }

 private:
  class ActingSink;
  void Run();
  void Wait(core::MonoTime deadline);
  void ReadPort(PortId id, drivers::ReconnectingPort& port, InputKind kind, core::MonoTime now);
  void ServicePort(PortId id, drivers::ReconnectingPort& port, PortWriter& writer,
                   core::MonoTime now);
  void TakeInbox();
  void Consume(InputKind kind, core::MonoTime mono, std::span<const std::uint8_t> bytes);
  void Measure(core::MonoTime deadline, core::MonoTime woke);

  RealtimeConfig realtime_;
  InputInbox& inbox_;
  OutputRing& output_;
  drivers::ReconnectingPort gps_port_;
  drivers::ReconnectingPort ahrs_port_;
  PortWriter gps_writer_;
  PortWriter ahrs_writer_;
  std::unique_ptr<ActingSink> sink_;
  RobotCore core_;
  std::int64_t sequence_ = 0;
  std::array<std::uint8_t, 2048> read_buffer_{};
  core::Counter& late_max_us_;
  core::Counter& late_over_10ms_;
  core::Counter& output_refused_;
  core::Counter& inbox_refused_;
  core::Counter& write_dropped_;
  Heartbeat heart_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kawara::onboard
