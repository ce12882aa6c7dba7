#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kawara::estimation {

/// The newest items with ascending `time`, counted from the start; allocates when made only.
template <class T>
class TimedRing {
 public:
  explicit TimedRing(std::size_t capacity) : items_(capacity) {}

  std::uint64_t end() const { return end_; }
  std::uint64_t begin() const { return begin_; }
  const T& operator[](std::uint64_t i) const { return items_[i % items_.size()]; }
  const T& back() const { return (*this)[end_ - 1]; }

  void Push(const T& item) {
    items_[end_ % items_.size()] = item;
    ++end_;
    if (end_ - begin_ > items_.size()) begin_ = end_ - items_.size();
  }
  /// Forgets the newest, from `end` on.
  void Rewind(std::uint64_t end) {
    end_ = end;
    if (begin_ > end_) begin_ = end_;
  }
  void Clear() { begin_ = end_; }

  /// The first whose time is after t; end() if none.
  template <class Time>
  std::uint64_t UpperBound(Time t) const {
    std::uint64_t low = begin_, high = end_;
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      if ((*this)[middle].time <= t) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

 private:
  std::vector<T> items_;
  std::uint64_t begin_ = 0;
  std::uint64_t end_ = 0;
};

}  // namespace kawara::estimation
