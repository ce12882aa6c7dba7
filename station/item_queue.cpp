#include "station/item_queue.hpp"

#include <algorithm>
#include <utility>

namespace kawara::station {

void ItemQueue::MakeRoom() {
  while (bytes_ > max_bytes_ && !items_.empty()) {
    auto victim = std::find_if(items_.begin(), items_.end(),
                               [](const Item& item) { return item.picture() != nullptr; });
    if (victim == items_.end()) victim = items_.begin();
    ++(victim->picture() != nullptr ? dropped_pictures_ : dropped_rows_);
    bytes_ -= victim->bytes();
    items_.erase(victim);
  }
}

void ItemQueue::Push(Item item) {
  {
    const std::lock_guard lock(mutex_);
    bytes_ += item.bytes();
    items_.push_back(std::move(item));
    MakeRoom();
  }
  filled_.notify_one();
}

std::vector<Item> ItemQueue::Pop(core::Duration timeout, std::size_t max_bytes) {
  std::unique_lock lock(mutex_);
  filled_.wait_for(lock, timeout, [this] { return !items_.empty() || stopped_; });
  std::vector<Item> batch;
  std::size_t taken = 0;
  while (!items_.empty() && (batch.empty() || taken + items_.front().bytes() <= max_bytes)) {
    taken += items_.front().bytes();
    bytes_ -= items_.front().bytes();
    batch.push_back(std::move(items_.front()));
    items_.pop_front();
  }
  return batch;
}

void ItemQueue::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  filled_.notify_all();
}

std::int64_t ItemQueue::dropped_pictures() const {
  const std::lock_guard lock(mutex_);
  return dropped_pictures_;
}

std::int64_t ItemQueue::dropped_rows() const {
  const std::lock_guard lock(mutex_);
  return dropped_rows_;
}

}  // namespace kawara::station
