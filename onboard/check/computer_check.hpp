#pragma once
#include <filesystem>

#include "onboard/check/finding.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// The computer as this user finds it: real-time rights, locked memory, processor governor, network
/// buffers and route, clock, room and rights for the recording. Changes nothing that stays: what it
/// tries it takes back. Takes under a second. `system` is the root of /proc and /sys (tests have
/// their own).
Findings CheckComputer(const OnboardConfig& config, const std::filesystem::path& system = "/");

}  // namespace kawara::onboard
