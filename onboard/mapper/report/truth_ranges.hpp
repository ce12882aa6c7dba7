#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::mapper {

/// True ranges [m] of a frame of a survey that kawara-sim has rendered, from
/// SURVEY/range/NAME.png (16 bits, millimetres; 0 outside the picture, 65535 sky or too far to be
/// told): rows from the top, NaN where unknown. Empty: the survey has no such file. Errors: kFormat
/// (no such picture, or of another size than the frame's), kPermission, kIo.
core::Expected<std::vector<float>> LoadTruth(const std::filesystem::path& survey,
                                             const std::string& frame, int width_px, int height_px);

}  // namespace kawara::mapper
