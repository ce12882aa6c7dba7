#include "drivers/correction_queue.hpp"

#include <algorithm>

namespace kawara::drivers {

bool CorrectionQueue::Push(std::span<const std::uint8_t> message) noexcept {
  if (!ready_) {
    for (std::size_t i = 0; i < kMessages; ++i) order_[i] = static_cast<std::uint8_t>(i);
    ready_ = true;
  }
  if (message.empty()) return true;
  if (message.size() > kMaxMessageBytes) {
    ++dropped_;
    return false;
  }
  const bool full = size_ == kMessages;
  if (full) {
    Remove(mid_message() ? 1 : 0);
    ++dropped_;
  }
  Slot& slot = slots_[order_[size_++]];
  slot.size = static_cast<std::uint16_t>(message.size());
  std::copy(message.begin(), message.end(), slot.bytes.begin());
  return !full;
}

std::span<const std::uint8_t> CorrectionQueue::Front() const noexcept {
  if (size_ == 0) return {};
  const Slot& slot = slots_[order_[0]];
  return std::span<const std::uint8_t>(slot.bytes).first(slot.size).subspan(consumed_);
}

void CorrectionQueue::Consume(std::size_t bytes) noexcept {
  const std::size_t left = Front().size();
  if (left == 0 || bytes == 0) return;
  if (bytes < left) {
    consumed_ += bytes;
    return;
  }
  consumed_ = 0;
  Remove(0);
}

std::size_t CorrectionQueue::Clear() noexcept {
  const std::size_t keep = mid_message() ? 1 : 0;
  const std::size_t gone = size_ - std::min(size_, keep);
  size_ -= gone;
  return gone;
}

void CorrectionQueue::Remove(std::size_t position) noexcept {
  const auto first = order_.begin() + static_cast<std::ptrdiff_t>(position);
  std::rotate(first, first + 1, order_.begin() + static_cast<std::ptrdiff_t>(size_));
  --size_;
}

}  // namespace kawara::drivers
