#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "core/counters.hpp"
#include "drivers/camera.hpp"
#include "onboard/frame_table.hpp"
#include "onboard/input_inbox.hpp"
#include "onboard/port_teller.hpp"

namespace kawara::onboard {

/// The camera's thread: takes frames as they come, parks them in the table and tells the core. Says
/// once when the camera is gone and once when it is back, and how long it exposes whenever that
/// changes.
class CameraReader {
 public:
  /// Sees each frame on the camera's thread, before it is handed on.
  using Watch = std::function<void(const drivers::Frame&)>;

  CameraReader(drivers::Camera& camera, FrameTable& frames, InputInbox& inbox,
               core::Counters& counters, Watch watch = {});
  ~CameraReader();  ///< Stop()
  CameraReader(const CameraReader&) = delete;
  CameraReader& operator=(const CameraReader&) = delete;
  void Stop();

 private:
  void Run();
  void Take(const std::shared_ptr<const drivers::Frame>& frame);
  void TellShutter(const drivers::Frame& frame);

  drivers::Camera& camera_;
  FrameTable& frames_;
  InputInbox& inbox_;
  PortTeller teller_;
  Watch watch_;
  core::Counter& frames_counter_;
  core::Counter& no_slot_;
  core::Duration shutter_{};  ///< the core was told last
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kawara::onboard
