#pragma once
#include <cstddef>
#include <vector>

namespace kawara::estimation {

/// The newest `capacity` items, oldest first, in slots that are written over: for items too large
/// to be moved about. Allocates when made only.
template <class T>
class SlotRing {
 public:
  explicit SlotRing(std::size_t capacity) : capacity_(capacity) { slots_.reserve(capacity); }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  const T& front() const { return slots_[first_]; }
  const T& back() const { return slots_[(first_ + size_ - 1) % capacity_]; }

  void Push(const T& item) {
    if (size_ == capacity_) {
      first_ = (first_ + 1) % capacity_;
      --size_;
    }
    const std::size_t slot = (first_ + size_) % capacity_;
    if (slot < slots_.size()) {
      slots_[slot] = item;
    } else {
      slots_.push_back(item);
    }
    ++size_;
  }
  /// Forgets the newest.
  void Pop() { --size_; }
  void Clear() { first_ = size_ = 0; }

 private:
  std::vector<T> slots_;
  std::size_t capacity_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace kawara::estimation
