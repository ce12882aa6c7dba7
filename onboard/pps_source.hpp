#pragma once
#include <memory>

#include "drivers/pps.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// Where the pulses of a configuration come from: the kernel for a name under /dev, a socket for
/// any other. `settings.device` must not be empty.
std::unique_ptr<drivers::PpsSource> MakePps(const PpsSettings& settings);

}  // namespace kawara::onboard
