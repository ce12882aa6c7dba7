#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

namespace kawara::comms {

/// Bounded queue of messages in one block of memory: many writers, one reader, no allocation after
/// construction. A writer reserves under the caller's lock (a few instructions) and copies outside
/// it; the reader sees messages in the order of their reservation, each once it is complete. When
/// full the new message is refused: what is already there is older, and a log without a hole in the
/// middle is worth more than its newest second.
class MessageRing {
 public:
  struct Message {
    std::int64_t number = 0;
    std::int64_t time_utc_us = 0;
    std::string_view channel;
    std::span<const std::uint8_t> data;
  };
  struct Slot;  ///< a reservation

  explicit MessageRing(std::size_t capacity_bytes);

  /// Room for a message; null: full. Only one thread at a time (the caller's lock). Channel up to
  /// 63 bytes.
  Slot* Reserve(std::int64_t number, std::int64_t time_utc_us, std::size_t channel_bytes,
                std::size_t data_bytes);
  /// Copies the message in and hands it to the reader. Any thread, once for each reservation, soon
  /// after it.
  static void Commit(Slot* slot, std::string_view channel, std::span<const std::uint8_t> data);

  /// Reader: the oldest message, if complete; valid until Pop.
  std::optional<Message> Front();
  void Pop();

  /// Bytes ever reserved and released, for "everything up to here" (Flush). Any thread.
  std::uint64_t head() const { return head_.load(std::memory_order_acquire); }
  std::uint64_t tail() const { return tail_.load(std::memory_order_acquire); }
  std::size_t queued_bytes() const { return static_cast<std::size_t>(head() - tail()); }
  std::size_t capacity_bytes() const { return capacity_; }

 private:
  Slot* At(std::uint64_t position) const;

  struct FreeAligned {
    void operator()(std::uint8_t* memory) const;
  };
  std::size_t capacity_;
  std::unique_ptr<std::uint8_t, FreeAligned> memory_;
  std::atomic<std::uint64_t> head_{0};
  std::atomic<std::uint64_t> tail_{0};
};

}  // namespace kawara::comms
