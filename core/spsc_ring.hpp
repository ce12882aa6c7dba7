#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/memcpy_safe.hpp"

namespace kawara::core {

/// Bounded queue of N items between exactly one producer thread and one consumer thread. Lock-free,
/// no allocation, no system call: both ends may be real-time threads.
///
/// A full ring is the reader's fault: PushDroppingOldest() (wait-free) throws the OLDEST item away
/// and counts it, so that what is read is always the newest N; TryPush() (wait-free) refuses the
/// new item instead and counts it. Items come out in the order they went in, each at most once.
///
/// How dropping stays safe while the consumer is reading the very item being dropped: the bytes
/// live in atomic words, and the consumer takes an item by advancing head_ only AFTER it has copied
/// it. The producer advances head_ itself before it overwrites. If the copy saw even one new word
/// (acquire load of a release store made after that advance), the consumer's compare-and-swap must
/// fail, and it starts again with the next item.
template <class T, std::size_t N>
class SpscRing {
  static_assert(kMemcpySafe<T>, "items are carried as bytes; see core/memcpy_safe.hpp");
  static_assert(N >= 1);

 public:
  SpscRing() = default;
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  static constexpr std::size_t capacity() { return N; }

  /// Producer only. Always succeeds; false if an old item had to go for it.
  bool PushDroppingOldest(const T& item) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    std::uint64_t head = head_.load(std::memory_order_acquire);
    bool kept_all = true;
    if (tail - head >= N) {
      // Fails only if the consumer has just taken that item itself: then there is room anyway.
      if (head_.compare_exchange_strong(head, head + 1, std::memory_order_acq_rel)) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        kept_all = false;
      }
    }
    Store(tail, item);
    return kept_all;
  }

  /// Producer only. False (and counted) if the ring is full; the item is not stored.
  bool TryPush(const T& item) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) >= N) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    Store(tail, item);
    return true;
  }

  /// Consumer only. False: empty, `out` is untouched.
  bool TryPop(T& out) {
    std::uint64_t head = head_.load(std::memory_order_acquire);
    while (head != tail_.load(std::memory_order_acquire)) {
      Words copy;
      const Slot& slot = slots_[head % N];
      for (std::size_t i = 0; i < kWords; ++i) copy[i] = slot[i].load(std::memory_order_acquire);
      if (head_.compare_exchange_strong(head, head + 1, std::memory_order_acq_rel)) {
        std::memcpy(static_cast<void*>(&out), copy.data(), sizeof(T));
        return true;
      }
    }
    return false;
  }

  /// Any thread; exact only while both ends are quiet.
  std::size_t size() const {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);
    return tail - head > N ? N : static_cast<std::size_t>(tail - head);
  }
  bool empty() const { return size() == 0; }
  /// Items lost for want of room since construction. Any thread.
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kWords =
      (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
  using Words = std::array<std::uint64_t, kWords>;
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;

  void Store(std::uint64_t tail, const T& item) {
    Words words{};
    std::memcpy(words.data(), static_cast<const void*>(&item), sizeof(T));
    Slot& slot = slots_[tail % N];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
    tail_.store(tail + 1, std::memory_order_release);
  }

  // Counts since construction, never reset: 64 bits do not wrap within the life of any machine.
  alignas(64) std::atomic<std::uint64_t> head_{0};  ///< next to take
  alignas(64) std::atomic<std::uint64_t> tail_{0};  ///< next to fill
  std::atomic<std::uint64_t> dropped_{0};
  alignas(64) std::array<Slot, N> slots_{};
};

}  // namespace kawara::core
