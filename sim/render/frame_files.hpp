#pragma once
#include <filesystem>

#include "core/expected.hpp"
#include "sim/render/renderer.hpp"

namespace kawara::sim {

/// Picture as JPEG (vision's encoder). Errors of all writers: kIo with the file's name.
core::Expected<void> WriteColour(const RenderedFrame& frame, const std::filesystem::path& jpeg,
                                 int quality = 92);

/// Picture without loss, PNG.
core::Expected<void> WriteColourPng(const RenderedFrame& frame, const std::filesystem::path& png);

/// Ranges as PFM: 32-bit floats in metres as they are (infinity, NaN), little-endian, rows from the
/// BOTTOM as the format has it. Source: Debevec's PFM description (netpbm pfm(5)).
core::Expected<void> WriteRangePfm(const RenderedFrame& frame, const std::filesystem::path& pfm);

/// Ranges as 16-bit PNG in whole millimetres: 0 outside the field of view, 65535 the sky and what
/// is farther than 65.534 m.
core::Expected<void> WriteRangePng(const RenderedFrame& frame, const std::filesystem::path& png);

/// Object ids as 16-bit PNG; ids above 65534 (the robot's body) are 65535.
core::Expected<void> WriteObjectsPng(const RenderedFrame& frame, const std::filesystem::path& png);

}  // namespace kawara::sim
