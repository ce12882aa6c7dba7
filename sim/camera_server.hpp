#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "drivers/camera_socket.hpp"
#include "sim/dice.hpp"
#include "sim/picture_source.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

struct CameraOptions {
  double exposure_delay_s = 0.0005;   ///< trigger pulse to start of exposure
  double exposure_jitter_s = 0.0001;  ///< standard deviation of it
  double readout_s = 0.015;  ///< least time from start of exposure to the first byte of the frame
  std::uint64_t seed = 3;
};

/// The triggered camera as a UNIX socket server (protocol: drivers/camera_socket.hpp). Each trigger
/// makes one exposure of `pictures` at that instant; between triggers the next picture
/// is prepared for when the next trigger is expected. One client at a time. A trigger older than
/// 100 ms when it is read makes no exposure (missed).
class CameraServer {
 public:
  struct Faults {
    bool hang = false;
    bool miss = false;
    bool late = false;
    bool dark = false;
    bool disconnected = false;
  };
  struct Exposure {
    std::uint32_t trigger_sequence = 0;
    std::uint32_t frame_sequence = 0;
    core::MonoTime mono;
    core::GpsTime gps;
  };
  struct Hooks {
    std::function<Faults(core::MonoTime)> faults;       ///< what is wrong at this time
    std::function<void(core::MonoTime)> trigger_pulse;  ///< the shutter line went active
    std::function<void(const Exposure&)> exposed;
  };
  struct Counters {
    std::uint64_t triggers = 0;
    std::uint64_t missed = 0;
    std::uint64_t frames = 0;  ///< delivered whole
    std::uint64_t lost = 0;    ///< exposed, not delivered
    std::uint64_t clients = 0;
    core::Duration
        longest_delivery{};  ///< trigger to last byte handed to the socket, without late ones
  };

  CameraServer(std::filesystem::path socket, const SimClock& clock,
               std::unique_ptr<PictureSource> pictures, const CameraOptions& options, Hooks hooks);
  ~CameraServer();
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;

  core::Expected<void> Listen();
  /// Serves until `stop`; the camera's thread runs it.
  void Run(const std::atomic<bool>& stop);
  /// After Run() has returned.
  const Counters& counters() const { return counters_; }

 private:
  struct FrameOut {
    drivers::CameraFrameHeader header;
    Picture picture;
  };
  void StopListening();
  void DropClient();
  void Accept();
  void TakeTriggers(const Faults& faults, const std::atomic<bool>& stop);
  void OnTrigger(const drivers::CameraTriggerMessage& message, const Faults& faults,
                 const std::atomic<bool>& stop);
  void Deliver(const FrameOut& frame, const std::atomic<bool>& stop);
  bool SendAll(const void* data, std::size_t size, const std::atomic<bool>& stop);
  void PrepareNext();

  std::filesystem::path socket_path_;
  const SimClock& clock_;
  std::unique_ptr<PictureSource> pictures_;
  CameraOptions options_;
  Hooks hooks_;
  Dice dice_;
  Counters counters_;

  int listen_fd_ = -1;
  int client_fd_ = -1;
  std::array<std::uint8_t, sizeof(drivers::CameraTriggerMessage)> message_{};
  std::size_t message_size_ = 0;
  std::uint32_t frame_sequence_ = 0;
  core::MonoTime last_trigger_{};
  core::Duration period_{};  ///< between the last two triggers
  core::MonoTime prepare_at_{};
  bool prepared_ = false;
  std::optional<FrameOut> held_back_;  ///< fault `late`: goes out with the next trigger
};

}  // namespace kawara::sim
