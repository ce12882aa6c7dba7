#pragma once
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "onboard/mapper/pair_maker.hpp"

namespace kawara::mapper {

/// Pairs on their way from the thread that makes them to the one that matches them. Few, as each
/// holds two pictures. Any thread.
class PairQueue {
 public:
  /// Waits for room. False: nobody wants them any more.
  bool Push(PicturePair pair) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return pairs_.size() < kRoom || closed_; });
    if (closed_) return false;
    pairs_.push_back(std::move(pair));
    changed_.notify_all();
    return true;
  }
  /// Waits for a pair, and calls waiting() now and then meanwhile. Empty: there will be no more.
  template <class Waiting>
  std::optional<PicturePair> Pop(const Waiting& waiting) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kPatience, [this] { return !pairs_.empty() || closed_; })) {
      lock.unlock();
      waiting();
      lock.lock();
    }
    if (pairs_.empty()) return {};
    PicturePair pair = std::move(pairs_.front());
    pairs_.pop_front();
    changed_.notify_all();
    return pair;
  }
  /// Whoever makes pairs waits, or soon will.
  bool full() const {
    const std::lock_guard lock(mutex_);
    return pairs_.size() >= kRoom;
  }
  /// No more pairs go in; those inside still come out.
  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  static constexpr std::size_t kRoom = 2;
  static constexpr std::chrono::milliseconds kPatience{200};
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<PicturePair> pairs_;
  bool closed_ = false;
};

}  // namespace kawara::mapper
