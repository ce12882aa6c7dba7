#include "station/epoch_gaps.hpp"

#include <algorithm>

namespace kawara::station {

bool EpochGaps::Take(std::int64_t number) {
  constexpr std::int64_t kMostHoles = 4096;
  if (next_ == 0) next_ = number;
  if (number < next_) {
    if (holes_.erase(number) == 0) return false;
    --missing_;
    ++late_;
    return true;
  }
  missing_ += number - next_;
  for (std::int64_t hole = std::max(next_, number - kMostHoles); hole < number; ++hole)
    holes_.insert(hole);
  while (static_cast<std::int64_t>(holes_.size()) > kMostHoles) holes_.erase(holes_.begin());
  next_ = number + 1;
  return true;
}

}  // namespace kawara::station
