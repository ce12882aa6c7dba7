#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace kawara::drivers {

/// Sets a camera's trigger control on a thread of its own: the ioctl goes over the bus and may take
/// milliseconds, and Fire() is called by the real-time thread. Only the newest trigger counts: one
/// that comes while another is being set replaces what waits. No locks between the two.
class V4l2TriggerThread {
 public:
  /// `pull` is called on the own thread, once a trigger.
  explicit V4l2TriggerThread(std::function<void()> pull);
  ~V4l2TriggerThread();
  V4l2TriggerThread(const V4l2TriggerThread&) = delete;
  V4l2TriggerThread& operator=(const V4l2TriggerThread&) = delete;

  /// Real-time safe: two atomic operations and a futex wake.
  void Fire();

 private:
  void Run();

  std::function<void()> pull_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint32_t> ordered_{0};
  std::thread thread_;
};

}  // namespace kawara::drivers
