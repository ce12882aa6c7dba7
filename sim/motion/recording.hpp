#pragma once
#include <filesystem>

#include "core/expected.hpp"
#include "sim/vehicle/measured_drive.hpp"

namespace kawara::sim {

/// Reads gnss.csv, imu.csv (each also as .gz) and site.csv of a data folder such as
/// data/drive_0708. Errors: kNotFound, kIo, and kFormat with file, line and column for wrong
/// headers, numbers, ranges and order.
core::Expected<Recording> LoadRecording(const std::filesystem::path& folder);

}  // namespace kawara::sim
