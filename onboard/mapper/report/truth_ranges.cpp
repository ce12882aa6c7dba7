#include "onboard/mapper/report/truth_ranges.hpp"

#include <cstdint>
#include <limits>
#include <string>

#include "onboard/survey/picture_file.hpp"
#include "vision/png.hpp"

namespace kawara::mapper {

core::Expected<std::vector<float>> LoadTruth(const std::filesystem::path& survey,
                                             const std::string& frame, int width_px,
                                             int height_px) {
  const std::filesystem::path file = survey / "range" / (frame + ".png");
  auto bytes = survey::ReadBytes(file);
  if (!bytes) {
    if (bytes.error().code == core::ErrorCode::kNotFound) return std::vector<float>{};
    return tl::unexpected(bytes.error());
  }
  const auto levels = vision::DecodeGrey16Png(*bytes);
  if (!levels || levels->width_px != width_px || levels->height_px != height_px) {
    return core::Fail(core::ErrorCode::kFormat,
                      file.string() + ": expected a grey PNG of 16 bits and " +
                          std::to_string(width_px) + " x " + std::to_string(height_px) +
                          " pixels, as the frame's; render the survey anew or remove its range/");
  }
  constexpr std::uint16_t kSky = 65535;
  std::vector<float> truth_m;
  truth_m.reserve(levels->level.size());
  for (const std::uint16_t level : levels->level) {
    const bool known = level != 0 && level != kSky;
    truth_m.push_back(known ? 1e-3F * static_cast<float>(level)
                            : std::numeric_limits<float>::quiet_NaN());
  }
  return truth_m;
}

}  // namespace kawara::mapper
