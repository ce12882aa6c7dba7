#pragma once
#include <functional>
#include <memory>

#include "core/expected.hpp"
#include "drivers/v4l2_camera.hpp"

namespace kawara::tools {

/// Hands out frames until `take` says false. Trouble that may pass (unplugged, hung) is told on
/// standard error once and waited out for `patience`; then kTimeout, with what the camera said.
/// Trouble that does not pass (permission, no such mode or control) is an error at once.
core::Expected<void> ForFrames(drivers::V4l2Camera& camera, core::Duration patience,
                               const std::function<bool(const drivers::Frame&)>& take);

}  // namespace kawara::tools
