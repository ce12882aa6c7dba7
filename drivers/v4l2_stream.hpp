#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "drivers/v4l2_device.hpp"

namespace kawara::drivers {

/// A filled buffer, on loan until V4l2Stream::GiveBack.
struct V4l2Loan {
  std::uint32_t index = 0;
  std::span<const std::uint8_t> bytes;  ///< as many as the device says it filled
  std::uint32_t sequence = 0;
  std::uint32_t flags = 0;   ///< V4L2_BUF_FLAG_*
  std::int64_t stamp_s = 0;  ///< as the device gave it, on whatever clock `flags` say
  std::int64_t stamp_us = 0;
  core::MonoTime arrival;  ///< when it was dequeued
};

/// Streaming through memory shared with the kernel: enough buffers that a reader who is late by a
/// few frames loses none. The destructor stops the stream and gives the memory back. One thread.
class V4l2Stream {
 public:
  /// Asked for; the kernel may give more, or fewer (kMinBuffers at least).
  static constexpr std::uint32_t kBuffers = 6;
  static constexpr std::uint32_t kMinBuffers = 2;

  /// `device` must live longer. kUnavailable: busy, or gone; kFull: no memory for buffers.
  static core::Expected<V4l2Stream> Start(V4l2Device& device);
  ~V4l2Stream();
  V4l2Stream(V4l2Stream&& other) noexcept;
  V4l2Stream& operator=(V4l2Stream&&) = delete;

  enum class Got : std::uint8_t { kFrame, kNothing };
  /// The next filled buffer. kNothing: none within `timeout`. Errors: the stream is dead, whatever
  /// the reason: let go of it and of the device.
  core::Expected<Got> Take(core::Duration timeout, V4l2Loan& loan);
  core::Expected<void> GiveBack(const V4l2Loan& loan);
  /// STREAMOFF and STREAMON again, all buffers queued: the gentlest cure of a camera that hangs.
  core::Expected<void> Restart();

  std::size_t buffers() const { return memory_.size(); }

 private:
  explicit V4l2Stream(V4l2Device& device) : device_(&device) {}
  core::Expected<void> Allocate();
  core::Expected<void> Queue(std::uint32_t index);
  core::Expected<void> SwitchOn();

  V4l2Device* device_;  ///< null: moved from
  std::vector<std::span<std::uint8_t>> memory_;
};

}  // namespace kawara::drivers
