#include "comms/message_ring.hpp"

#include <cstring>
#include <new>

#include "comms/event_log.hpp"
#include "core/check.hpp"

namespace kawara::comms {
namespace {

constexpr std::size_t kAlignment = 128;
enum class SlotState : std::uint32_t { kReserved, kComplete, kSkip };

constexpr std::size_t RoundUp(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

}  // namespace

/// Stands before every message in the ring; data follow it.
struct MessageRing::Slot {
  std::atomic<SlotState> state{SlotState::kReserved};
  std::uint32_t channel_bytes = 0;
  std::uint64_t total_bytes = 0;  ///< with this header, rounded up
  std::uint64_t data_bytes = 0;
  std::int64_t number = 0;
  std::int64_t time_utc_us = 0;
  char channel[kLogMaxChannelBytes + 1] = {};

  std::uint8_t* data() { return reinterpret_cast<std::uint8_t*>(this) + RoundUp(sizeof(Slot)); }
};

void MessageRing::FreeAligned::operator()(std::uint8_t* memory) const {
  ::operator delete (memory, std::align_val_t{kAlignment});
}

MessageRing::MessageRing(std::size_t capacity_bytes) : capacity_(RoundUp(capacity_bytes)) {
  static_assert(RoundUp(sizeof(Slot)) == kAlignment);
  memory_.reset(
      static_cast<std::uint8_t*>(::operator new (capacity_, std::align_val_t{kAlignment})));
  std::memset(memory_.get(), 0, capacity_);  // touched now, not page by page while recording
}

MessageRing::Slot* MessageRing::At(std::uint64_t position) const {
  return std::launder(reinterpret_cast<Slot*>(memory_.get() + position % capacity_));
}

MessageRing::Slot* MessageRing::Reserve(std::int64_t number, std::int64_t time_utc_us,
                                        std::size_t channel_bytes, std::size_t data_bytes) {
  if (data_bytes > capacity_) return nullptr;
  const std::size_t total = kAlignment + RoundUp(data_bytes);
  std::uint64_t head = head_.load(std::memory_order_relaxed);
  const std::uint64_t tail = tail_.load(std::memory_order_acquire);
  const std::size_t until_wrap = capacity_ - static_cast<std::size_t>(head % capacity_);
  const std::size_t skipped = total > until_wrap ? until_wrap : 0;
  if (head - tail + skipped + total > capacity_) return nullptr;
  if (skipped > 0) {
    Slot* skip = new (memory_.get() + head % capacity_) Slot;
    skip->total_bytes = skipped;
    skip->state.store(SlotState::kSkip, std::memory_order_relaxed);
    head += skipped;
  }
  Slot* slot = new (memory_.get() + head % capacity_) Slot;
  slot->channel_bytes = static_cast<std::uint32_t>(channel_bytes);
  slot->total_bytes = total;
  slot->data_bytes = data_bytes;
  slot->number = number;
  slot->time_utc_us = time_utc_us;
  head_.store(head + total, std::memory_order_release);
  return slot;
}

void MessageRing::Commit(Slot* slot, std::string_view channel, std::span<const std::uint8_t> data) {
  CORE_CHECK(channel.size() == slot->channel_bytes && data.size() == slot->data_bytes);
  std::memcpy(slot->channel, channel.data(), channel.size());
  if (!data.empty()) std::memcpy(slot->data(), data.data(), data.size());
  slot->state.store(SlotState::kComplete, std::memory_order_release);
}

std::optional<MessageRing::Message> MessageRing::Front() {
  std::uint64_t tail = tail_.load(std::memory_order_relaxed);
  while (tail != head_.load(std::memory_order_acquire)) {
    Slot* slot = At(tail);
    const SlotState state = slot->state.load(std::memory_order_acquire);
    if (state == SlotState::kReserved) return std::nullopt;
    if (state == SlotState::kComplete) {
      return Message{slot->number,
                     slot->time_utc_us,
                     {slot->channel, slot->channel_bytes},
                     {slot->data(), static_cast<std::size_t>(slot->data_bytes)}};
    }
    tail += slot->total_bytes;
    tail_.store(tail, std::memory_order_release);
  }
  return std::nullopt;
}

void MessageRing::Pop() {
  const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
  tail_.store(tail + At(tail)->total_bytes, std::memory_order_release);
}

}  // namespace kawara::comms
