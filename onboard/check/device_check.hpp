#pragma once
#include "onboard/check/finding.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// The instruments of a configuration, each opened as the robot opens it and listened to: bytes of
/// the serial ports, a frame or at least an answer of the camera, an edge of the pulse. Sends
/// nothing. Takes up to some seconds, more for each that is silent.
Findings CheckDevices(const OnboardConfig& config);

}  // namespace kawara::onboard
