#include "core/measurements.hpp"

namespace kawara::core {

const char* ToString(RtkState s) {
  switch (s) {
    case RtkState::kNone:
      return "none";
    case RtkState::kAutonomous:
      return "autonomous";
    case RtkState::kCodeDifferential:
      return "dgps";
    case RtkState::kFloat:
      return "float";
    case RtkState::kFixed:
      return "fixed";
    case RtkState::kDeadReckoning:
      return "dead-reckoning";
  }
  return "none";
}

const char* ToString(PictureReason r) {
  switch (r) {
    case PictureReason::kEveryEpochs:
      return "every_n";
    case PictureReason::kDistance:
      return "distance";
    case PictureReason::kCommand:
      return "command";
    case PictureReason::kFreeRunning:
      return "free_running";
  }
  return "every_n";
}

}  // namespace kawara::core
