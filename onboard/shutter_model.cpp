#include "onboard/shutter_model.hpp"

#include <algorithm>
#include <chrono>

namespace kawara::onboard {

/// The plain mean of the first ones, then what the last kEnough weigh most in.
void ShutterModel::Smooth(Learnt& value, core::Duration seen) const {
  const int weight = std::min(seen_ + 1, kEnough);
  const core::Duration deviation = seen - value.mean;
  value.mean += deviation / weight;
  if (seen_ > 0) value.scatter += (std::chrono::abs(deviation) - value.scatter) / weight;
}

void ShutterModel::Learn(core::MonoTime fired, core::MonoTime stamp, core::MonoTime start) {
  Smooth(lead_, start - fired);
  Smooth(stamp_, stamp - start);
  seen_ = std::min(seen_ + 1, kEnough + 1);
}

std::optional<core::MonoTime> ShutterModel::StartOf(core::MonoTime fired,
                                                    core::MonoTime stamp) const {
  if (seen_ < kEnough) return std::nullopt;
  return lead_.scatter < stamp_.scatter ? fired + lead_.mean : stamp - stamp_.mean;
}

}  // namespace kawara::onboard
