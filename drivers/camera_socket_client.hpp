#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "drivers/camera.hpp"
#include "drivers/camera_socket.hpp"

namespace kawara::drivers {

/// Reads a frame header as it came over the socket. kFormat: wrong magic or format, sizes of zero
/// or beyond kCameraMaxSidePx, a payload that is empty, too large, or not what the sizes of a raw
/// picture demand. Pure; any thread.
core::Expected<CameraFrameHeader> ParseCameraFrameHeader(
    std::span<const std::uint8_t, sizeof(CameraFrameHeader)> bytes);
constexpr std::uint32_t kCameraMaxSidePx = 32768;

/// Puts frames together from the bytes of the socket, in whatever pieces they come. Holds at most
/// one frame, so its memory is bounded by kCameraMaxPayloadBytes, and grows with what has arrived,
/// not with what a header claims. After an error the stream has no frame boundary any more:
/// reconnect and Reset(). One thread.
class CameraFrameAssembler {
 public:
  /// Takes bytes off the front of `bytes` until a frame is complete (returned; `bytes` may have
  /// some left for the next call) or none is left (null). `now` becomes the frame's arrival.
  core::Expected<std::shared_ptr<const Frame>> Feed(core::MonoTime now,
                                                    std::span<const std::uint8_t>& bytes);
  /// Forgets a frame begun.
  void Reset();

 private:
  std::array<std::uint8_t, sizeof(CameraFrameHeader)> header_bytes_{};
  std::size_t header_size_ = 0;
  std::uint32_t payload_bytes_ = 0;
  std::shared_ptr<Frame> frame_;  ///< null while the header is incomplete
};

/// The camera behind a UNIX stream socket (see camera_socket.hpp): the simulated one, or any
/// process that speaks the same. Connects on demand in Next() and again after every loss. A frame
/// that stops half-way for longer than `stall` counts as a loss.
///
/// Threads as drivers::Camera says: Trigger() from one thread, everything else from another, no
/// lock between them. The descriptor's number stays the same for life: a new connection is put
/// under it with dup3(), which is atomic, so that Trigger() never meets a foreign file.
class SocketCamera final : public Camera {
 public:
  struct Stats {
    std::uint64_t connects = 0;
    std::uint64_t disconnects = 0;
    std::uint64_t frames = 0;
    std::uint64_t format_errors = 0;
  };

  explicit SocketCamera(std::string path, core::Duration stall = core::Seconds(3));
  ~SocketCamera() override;
  SocketCamera(const SocketCamera&) = delete;
  SocketCamera& operator=(const SocketCamera&) = delete;

  core::Expected<void> Trigger(std::uint32_t sequence) override;
  core::Expected<std::shared_ptr<const Frame>> Next(core::Duration timeout) override;

  bool connected() const { return connected_.load(std::memory_order_acquire); }
  /// Triggers that could not be sent (not connected, or a camera that does not read). Any thread.
  std::uint64_t lost_triggers() const { return lost_triggers_.load(std::memory_order_relaxed); }
  const Stats& stats() const { return stats_; }  ///< camera thread only

 private:
  core::Expected<void> Connect();
  core::Expected<std::shared_ptr<const Frame>> Lose(core::Error why);

  std::string path_;
  core::Duration stall_;
  int fd_ = -1;  ///< constant after construction
  std::atomic<bool> connected_{false};
  std::atomic<std::uint64_t> lost_triggers_{0};
  CameraFrameAssembler assembler_;
  std::array<std::uint8_t, 65536> buffer_;
  std::size_t buffer_begin_ = 0, buffer_end_ = 0;
  core::MonoTime last_bytes_{};  ///< set while a frame is incomplete
  Stats stats_;
};

}  // namespace kawara::drivers
