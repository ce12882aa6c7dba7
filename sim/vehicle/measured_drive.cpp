#include "sim/vehicle/measured_drive.hpp"

#include <algorithm>

namespace kawara::sim {

core::GpsTime Recording::begin() const { return std::max(fixes.front().time, imu.front().time); }
core::GpsTime Recording::end() const { return std::min(fixes.back().time, imu.back().time); }

void Recording::Shift(core::Duration by) {
  for (RecordedFix& fix : fixes) fix.time += by;
  for (RecordedImu& sample : imu) sample.time += by;
}

}  // namespace kawara::sim
