#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

#include "core/time.hpp"
#include "station/item.hpp"

namespace kawara::station {

/// Between the thread that hears the bus and the one that writes the store. Bounded in bytes: when
/// full, the OLDEST picture gives way (navigation and events only when no picture is left), and is
/// counted. Any number of threads.
class ItemQueue {
 public:
  explicit ItemQueue(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  void Push(Item item);
  /// Waits up to `timeout` for the first item, then hands over what is there, oldest first, as long
  /// as the batch stays below `max_bytes`. Empty: nothing came, or Stop().
  std::vector<Item> Pop(core::Duration timeout, std::size_t max_bytes);
  /// Pop() does not wait any more.
  void Stop();

  std::int64_t dropped_pictures() const;
  std::int64_t dropped_rows() const;

 private:
  void MakeRoom();

  const std::size_t max_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Item> items_;
  std::size_t bytes_ = 0;
  bool stopped_ = false;
  std::int64_t dropped_pictures_ = 0;
  std::int64_t dropped_rows_ = 0;
};

}  // namespace kawara::station
