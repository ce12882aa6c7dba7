#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

#include "core/memcpy_safe.hpp"

namespace kawara::core {

/// Bounded queue of records (a fixed Header and any number of bytes) between exactly one producer
/// thread and one consumer thread, for the way to the recorder: what does not fit is refused and
/// counted, never half stored, because here the OLD records are the ones that must not be lost.
/// Lock-free; all memory is taken and touched in the constructor (no page fault later).
///
/// Each record is contiguous in memory, so the consumer reads it in place. A record of up to
/// max_record_bytes() (about half the ring) always fits into an empty ring, wherever its ends
/// happen to stand.
template <class Header>
class ByteRing {
  static_assert(kMemcpySafe<Header>, "headers are carried as bytes; see core/memcpy_safe.hpp");

 public:
  /// `capacity_bytes` of record storage, rounded up to whole 16-byte units; at least one empty
  /// record's worth.
  explicit ByteRing(std::size_t capacity_bytes)
      : capacity_(RoundUp(std::max(capacity_bytes, 2 * kOverhead))),
        storage_(std::make_unique<std::uint8_t[]>(capacity_)) {}
  ByteRing(const ByteRing&) = delete;
  ByteRing& operator=(const ByteRing&) = delete;

  std::size_t capacity_bytes() const { return capacity_; }
  /// Longest `bytes` that TryPush can ever accept.
  std::size_t max_record_bytes() const { return capacity_ / 2 / kAlign * kAlign - kOverhead; }

  /// Producer only, wait-free. False (and counted) if there is no room now or `bytes` is too long
  /// for ever.
  bool TryPush(const Header& header, std::span<const std::uint8_t> bytes) {
    if (bytes.size() > max_record_bytes()) return Refuse();
    const std::uint64_t needed = RoundUp(kOverhead + bytes.size());
    std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    const std::uint64_t to_end = capacity_ - tail % capacity_;
    const std::uint64_t skip = to_end < needed ? to_end : 0;
    if (tail - head + skip + needed > capacity_) return Refuse();
    if (skip != 0) {
      WriteLength(tail, kSkip);
      tail += skip;
    }
    WriteLength(tail, bytes.size());
    std::uint8_t* record = At(tail);
    std::memcpy(record + sizeof(std::uint64_t), static_cast<const void*>(&header), sizeof(Header));
    if (!bytes.empty()) std::memcpy(record + kOverhead, bytes.data(), bytes.size());
    tail_.store(tail + needed, std::memory_order_release);
    return true;
  }

  /// Consumer only. False: empty. Else calls take(const Header&, std::span<const std::uint8_t>)
  /// with a view that is valid during the call, and frees the record when take returns.
  template <class Take>
  bool TryPop(Take&& take) {
    std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    std::uint64_t length = ReadLength(head);
    if (length == kSkip) {  // a record always follows: both were published by one store
      head += capacity_ - head % capacity_;
      length = ReadLength(head);
    }
    Header header;
    std::memcpy(static_cast<void*>(&header), At(head) + sizeof(std::uint64_t), sizeof(Header));
    take(static_cast<const Header&>(header),
         std::span<const std::uint8_t>(At(head) + kOverhead, static_cast<std::size_t>(length)));
    head_.store(head + RoundUp(kOverhead + length), std::memory_order_release);
    return true;
  }

  /// Bytes in use, overhead included. Any thread; exact only while both ends are quiet.
  std::size_t used_bytes() const {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(std::min<std::uint64_t>(tail - head, capacity_));
  }
  bool empty() const { return used_bytes() == 0; }
  /// Records refused since construction. Any thread.
  std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kAlign = 16;
  static constexpr std::uint64_t kSkip =
      ~std::uint64_t{0};  ///< length that means: go on at the ring's start
  static constexpr std::size_t RoundUp(std::size_t n) { return (n + kAlign - 1) / kAlign * kAlign; }
  static constexpr std::size_t kOverhead = RoundUp(sizeof(std::uint64_t) + sizeof(Header));

  std::uint8_t* At(std::uint64_t position) const { return storage_.get() + position % capacity_; }
  void WriteLength(std::uint64_t position, std::uint64_t length) {
    std::memcpy(At(position), &length, sizeof(length));
  }
  std::uint64_t ReadLength(std::uint64_t position) const {
    std::uint64_t length = 0;
    std::memcpy(&length, At(position), sizeof(length));
    return length;
  }
  bool Refuse() {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  const std::size_t capacity_;
  const std::unique_ptr<std::uint8_t[]> storage_;
  alignas(64) std::atomic<std::uint64_t> head_{0};  ///< bytes freed since construction
  alignas(64) std::atomic<std::uint64_t> tail_{0};  ///< bytes filled since construction
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace kawara::core
