#pragma once
#include <array>
#include <cstddef>

namespace kawara::estimation {

/// The newest N items in the order of their `time` member, oldest first. Fixed memory; a full
/// history forgets its oldest. Times are unique.
template <class T, std::size_t N>
class History {
 public:
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t i) const { return items_[(first_ + i) % N]; }
  const T& front() const { return (*this)[0]; }
  const T& back() const { return (*this)[size_ - 1]; }

  /// Puts the item in its place (at the end in the ordinary case). False: its time is there
  /// already, or it is older than everything in a full history.
  bool Insert(const T& item) {
    std::size_t place = size_;
    while (place > 0 && item.time < (*this)[place - 1].time) --place;
    if (place > 0 && (*this)[place - 1].time == item.time) return false;
    if (size_ == N) {
      if (place == 0) return false;
      first_ = (first_ + 1) % N;
      --size_;
      --place;
    }
    ++size_;
    for (std::size_t i = size_ - 1; i > place; --i) At(i) = At(i - 1);
    At(place) = item;
    return true;
  }

  /// How many items have a time <= t.
  template <class Time>
  std::size_t CountUpTo(Time t) const {
    std::size_t low = 0, high = size_;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if ((*this)[middle].time <= t) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

  void Clear() { size_ = 0; }

 private:
  T& At(std::size_t i) { return items_[(first_ + i) % N]; }

  std::array<T, N> items_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace kawara::estimation
