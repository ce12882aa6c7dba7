#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "drivers/camera.hpp"

namespace kawara::onboard {

/// Where frames wait while only their number travels through the real-time core. The camera thread
/// puts, the threads that record and draw pictures take. Bounded: when all slots are taken the
/// frame is refused (and counted by the caller). Any thread except the real-time one.
class FrameTable {
 public:
  static constexpr std::size_t kSlots = 32;

  std::optional<std::uint32_t> Put(std::shared_ptr<const drivers::Frame> frame);
  /// Null: no frame there.
  std::shared_ptr<const drivers::Frame> Get(std::uint32_t slot) const;
  void Release(std::uint32_t slot);

 private:
  mutable std::mutex mutex_;
  std::array<std::shared_ptr<const drivers::Frame>, kSlots> slots_;
};

}  // namespace kawara::onboard
