#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/check.hpp"

namespace kawara::mapper {

/// A few at even distances of any number of things that are offered one after the other, in fixed
/// memory: the first always, never more than `most`, and from there on never fewer than half of
/// it. Which they are depends only on how many were offered. One thread.
template <class T>
class EvenlySpread {
 public:
  /// `most`: even, at least 2.
  explicit EvenlySpread(std::size_t most) : most_(most) { CORE_CHECK(most >= 2 && most % 2 == 0); }

  /// `make` gives the thing, and is called only if it is kept.
  template <class Make>
  void Offer(Make&& make) {
    if (offered_++ % stride_ != 0) return;
    if (kept_.size() == most_) {
      // As `most` is even, the one offered now is again a multiple of the stride.
      for (std::size_t i = 1; i < most_ / 2; ++i) kept_[i] = std::move(kept_[2 * i]);
      kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(most_ / 2), kept_.end());
      stride_ *= 2;
    }
    kept_.push_back(make());
  }

  const std::vector<T>& kept() const { return kept_; }

 private:
  std::size_t most_;
  std::uint64_t offered_ = 0, stride_ = 1;
  std::vector<T> kept_;
};

}  // namespace kawara::mapper
