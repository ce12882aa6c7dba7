#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "drivers/camera_socket.hpp"
#include "sim/camera/picture_source.hpp"
#include "sim/camera/triggered_camera.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

/// A TriggeredCamera on a UNIX socket (protocol: drivers/camera_socket.hpp). Between triggers the
/// next picture is prepared for when the next trigger is expected. One client at a time.
class CameraServer {
 public:
  using Faults = TriggeredCamera::Faults;
  using Exposure = TriggeredCamera::Exposure;
  struct Hooks {
    std::function<Faults(core::MonoTime)> faults;  ///< what is wrong at this time
    std::function<void(core::MonoTime)> signal;    ///< its signal line went active
    std::function<void(const Exposure&)> exposed;
  };
  struct Counters {
    std::uint64_t triggers = 0;  ///< these two as TriggeredCamera counts them
    std::uint64_t missed = 0;
    std::uint64_t frames = 0;  ///< delivered whole
    std::uint64_t lost = 0;    ///< exposed, not delivered
    std::uint64_t clients = 0;
    std::uint64_t made_late = 0;  ///< frames whose picture was not ready when the trigger came
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
  Counters counters() const;

 private:
  void StopListening();
  void DropClient();
  void Accept();
  void TakeTriggers(const Faults& faults, const std::atomic<bool>& stop);
  void OnTrigger(const drivers::CameraTriggerMessage& message, const Faults& faults,
                 const std::atomic<bool>& stop);
  void Deliver(const TriggeredCamera::Frame& frame, const std::atomic<bool>& stop);
  void WasBusySince(core::MonoTime begin);
  bool SendAll(const void* data, std::size_t size, const std::atomic<bool>& stop);

  std::filesystem::path socket_path_;
  std::function<Faults(core::MonoTime)> faults_;
  TriggeredCamera camera_;
  Counters counters_;

  int listen_fd_ = -1;
  int client_fd_ = -1;
  std::array<std::uint8_t, sizeof(drivers::CameraTriggerMessage)> message_{};
  std::size_t message_size_ = 0;
  /// When the thread last made pictures instead of reading triggers.
  core::MonoTime busy_from_{}, busy_until_{};
};

}  // namespace kawara::sim
