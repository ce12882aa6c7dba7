#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "onboard/survey/calibration_file.hpp"

/// Any bytes as a calibration; the first one says how an OpenCV file is to be read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara;
  if (size == 0) return 0;
  const auto model = static_cast<survey::OpenCvModel>(data[0] % 4);
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  const auto all = survey::ParseCalibration(text, "file", model);
  if (!all) {
    if (all.error().message.empty()) std::abort();
    return 0;
  }
  for (const survey::Calibration& one : *all) {
    if (std::abs(one.body_from_optical.linear().determinant() - 1.0) > 1e-9) std::abort();
    const auto camera = vision::MakeCamera(one.optics);
    if (!camera) continue;
    const auto pixel = (*camera)->Project({0.1, -0.2, 1.0});
    if (pixel && !pixel->allFinite()) std::abort();
  }
  return 0;
}
