#pragma once
#include <cstdint>
#include <vector>

#include "core/counters.hpp"
#include "core/time.hpp"

namespace kawara::onboard {

/// All counters as they stand, encoded for channel COUNTERS. Allocates.
std::vector<std::uint8_t> CountersMessage(const core::Counters& counters, core::MonoTime now);

}  // namespace kawara::onboard
