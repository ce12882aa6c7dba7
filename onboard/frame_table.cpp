#include "onboard/frame_table.hpp"

#include <utility>

namespace kawara::onboard {

std::optional<std::uint32_t> FrameTable::Put(std::shared_ptr<const drivers::Frame> frame) {
  const std::lock_guard lock(mutex_);
  for (std::uint32_t i = 0; i < kSlots; ++i) {
    if (slots_[i]) continue;
    slots_[i] = std::move(frame);
    return i;
  }
  return std::nullopt;
}

std::shared_ptr<const drivers::Frame> FrameTable::Get(std::uint32_t slot) const {
  const std::lock_guard lock(mutex_);
  return slot < kSlots ? slots_[slot] : nullptr;
}

void FrameTable::Release(std::uint32_t slot) {
  const std::lock_guard lock(mutex_);
  if (slot < kSlots) slots_[slot].reset();
}

}  // namespace kawara::onboard
