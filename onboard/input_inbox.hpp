#pragma once
#include <cstdint>
#include <mutex>
#include <span>

#include "core/byte_ring.hpp"
#include "onboard/input.hpp"

namespace kawara::onboard {

/// The door by which all slower threads (camera, bus, corrections, pictures, recorder) reach the
/// real-time loop. They queue among themselves at a lock; the loop takes without one, and is woken
/// through fd().
class InputInbox {
 public:
  InputInbox();
  ~InputInbox();
  InputInbox(const InputInbox&) = delete;
  InputInbox& operator=(const InputInbox&) = delete;

  /// Any thread but the real-time one. False (and counted): the loop does not keep up.
  bool Post(InputKind kind, core::MonoTime mono, std::span<const std::uint8_t> bytes);
  bool PostFrame(const FrameInput& frame);

  /// Real-time thread only: calls take(InputKind, MonoTime, bytes) for one input; false: nothing
  /// there.
  template <class Take>
  bool TryTake(Take&& take) {
    return ring_.TryPop([&](const Header& header, std::span<const std::uint8_t> bytes) {
      take(header.kind, header.mono, bytes);
    });
  }
  /// Readable while something may be inside; Acknowledge() before taking.
  int fd() const { return event_fd_; }
  void Acknowledge();
  std::uint64_t refused() const { return ring_.refused(); }

 private:
  struct Header {
    InputKind kind = InputKind::kTick;
    core::MonoTime mono;
  };
  std::mutex producers_;
  core::ByteRing<Header> ring_;
  int event_fd_ = -1;
};

}  // namespace kawara::onboard
