#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/rtcm3_frame.hpp"

namespace kawara::drivers {

/// Whole messages on their way to a port that takes bytes at its own pace. Fixed memory; when it is
/// full, the oldest message not yet begun gives way and is counted. A message of which a byte has
/// gone out is finished, always. Real-time safe. One thread.
class CorrectionQueue {
 public:
  static constexpr std::size_t kMessages = 64;  ///< some seconds of a busy caster
  static constexpr std::size_t kMaxMessageBytes = kRtcm3MaxFrameBytes;

  /// False if an older message had to go, or if it is longer than kMaxMessageBytes and was not
  /// taken.
  bool Push(std::span<const std::uint8_t> message) noexcept;
  /// What is left of the oldest message; empty if there is none.
  std::span<const std::uint8_t> Front() const noexcept;
  /// `bytes` of Front() are out.
  void Consume(std::size_t bytes) noexcept;
  /// All but a message begun. Returns how many went.
  std::size_t Clear() noexcept;

  std::size_t size() const { return size_; }
  bool mid_message() const { return consumed_ > 0; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Slot {
    std::uint16_t size = 0;
    std::array<std::uint8_t, kMaxMessageBytes> bytes;
  };
  void Remove(std::size_t position) noexcept;

  std::array<Slot, kMessages> slots_;
  std::array<std::uint8_t, kMessages>
      order_{};  ///< slot numbers, oldest first; the free ones after size_
  std::size_t size_ = 0;
  std::size_t consumed_ = 0;
  std::uint64_t dropped_ = 0;
  bool ready_ = false;
};

}  // namespace kawara::drivers
