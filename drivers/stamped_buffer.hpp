#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/time.hpp"

namespace kawara::drivers {

/// Bytes waiting to become packets, each dated: byte i of a chunk came i character times after the
/// chunk's first byte, but not after the next chunk's first. In place, no allocation; one thread.
/// kCapacity must exceed twice the longest thing a decoder may leave unconsumed.
template <std::size_t kCapacity>
class StampedBuffer {
 public:
  explicit StampedBuffer(core::Duration byte_time) : byte_time_(byte_time) {}

  /// Takes the first bytes of `chunk`, as many as there is room for, and says how many.
  std::size_t Append(core::MonoTime arrival, std::span<const std::uint8_t> chunk) {
    if (end_ + chunk.size() > kCapacity && begin_ > 0) {
      std::memmove(bytes_.data(), bytes_.data() + begin_, size());
      end_ -= begin_;
      begin_ = 0;
    }
    const std::size_t n = std::min(chunk.size(), kCapacity - end_);
    if (n == 0) return 0;
    AddMark(arrival);
    std::memcpy(bytes_.data() + end_, chunk.data(), n);
    end_ += n;
    return n;
  }

  std::span<const std::uint8_t> data() const { return {bytes_.data() + begin_, size()}; }
  std::size_t size() const { return end_ - begin_; }
  /// Position in the whole stream of data()[0].
  std::uint64_t position() const { return position_; }

  void Consume(std::size_t n) {
    begin_ += n;
    position_ += n;
    while (marks_count_ > 1 && Mark(1).position <= position_) {
      marks_head_ = (marks_head_ + 1) % kMarks;
      --marks_count_;
    }
  }

  /// When data()[0] arrived.
  core::MonoTime FrontStamp() const {
    if (marks_count_ == 0) return {};
    const auto ahead = static_cast<std::int64_t>(position_ - Mark(0).position);
    const core::MonoTime stamp = Mark(0).arrival + ahead * byte_time_;
    return marks_count_ > 1 ? std::min(stamp, Mark(1).arrival) : stamp;
  }

  void Clear() {
    position_ += size();
    begin_ = end_ = 0;
    marks_count_ = 0;
  }

  core::Duration byte_time() const { return byte_time_; }

 private:
  /// Chunks of one byte each fill this; then later ones are dated from earlier ones by byte_time.
  static constexpr std::size_t kMarks = 256;
  struct ChunkMark {
    std::uint64_t position = 0;
    core::MonoTime arrival;
  };

  const ChunkMark& Mark(std::size_t i) const { return marks_[(marks_head_ + i) % kMarks]; }

  void AddMark(core::MonoTime arrival) {
    if (marks_count_ == kMarks) return;
    // An empty buffer leaves one old mark behind, which the new chunk replaces.
    if (size() == 0) marks_count_ = 0;
    marks_[(marks_head_ + marks_count_) % kMarks] = {position_ + size(), arrival};
    ++marks_count_;
  }

  core::Duration byte_time_;
  std::array<std::uint8_t, kCapacity> bytes_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t position_ = 0;
  std::array<ChunkMark, kMarks> marks_{};
  std::size_t marks_head_ = 0;
  std::size_t marks_count_ = 0;
};

}  // namespace kawara::drivers
