#include "onboard/mapper/range_files.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "gis/model/whole_file.hpp"
#include "onboard/mapper/report/range_colours.hpp"
#include "vision/png.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;
using vision::RangeImage;

static_assert(std::endian::native == std::endian::little, "PFM is written as it lies in memory");

core::Expected<void> WriteWhole(const fs::path& path, const void* data, std::size_t bytes) {
  return gis::WriteWholeFile(path, {static_cast<const char*>(data), bytes});
}

template <class Picture>
core::Expected<void> WritePng(const Picture& picture, const fs::path& path) {
  const auto bytes = vision::EncodePng(picture, vision::kPngFast);
  if (!bytes) return core::Fail(bytes.error().code, path.string() + ": " + bytes.error().message);
  return WriteWhole(path, bytes->data(), bytes->size());
}

/// In units of `unit_m`; 0 where unknown, 65535 beyond the scale.
vision::Grey16Picture Levels(const std::vector<float>& values_m, const RangeImage& size,
                             float unit_m) {
  vision::Grey16Picture picture{{}, size.width_px, size.height_px};
  picture.level.reserve(values_m.size());
  for (const float value : values_m) {
    const float level = std::isnan(value) ? 0.0F : std::clamp(value / unit_m, 1.0F, 65535.0F);
    picture.level.push_back(static_cast<std::uint16_t>(std::lround(level)));
  }
  return picture;
}

core::Expected<void> WritePfm(const std::vector<float>& values_m, const RangeImage& size,
                              const fs::path& path) {
  const std::string head =
      "Pf\n" + std::to_string(size.width_px) + " " + std::to_string(size.height_px) + "\n-1.0\n";
  std::vector<char> bytes(head.begin(), head.end());
  // Rows from the bottom. Source: Debevec's description of the format, netpbm pfm(5).
  for (int v = size.height_px; v-- > 0;) {
    const auto* row = reinterpret_cast<const char*>(values_m.data() + size.index(0, v));
    bytes.insert(bytes.end(), row, row + sizeof(float) * static_cast<std::size_t>(size.width_px));
  }
  return WriteWhole(path, bytes.data(), bytes.size());
}

}  // namespace

core::Expected<RangeFiles> WriteRangeFiles(const RangeImage& ranges, const fs::path& folder,
                                           const std::string& name) {
  const RangeFiles files{folder / (name + ".range.png"), folder / (name + ".sd.png"),
                         folder / (name + ".range.pfm"), folder / (name + ".sd.pfm"),
                         folder / (name + ".view.png")};
  constexpr float kMillimetre = 1e-3F, kTenth = 1e-4F;
  const std::vector<std::uint8_t> view = RangeColours(ranges);
  const auto all =
      WritePng(Levels(ranges.range_m, ranges, kMillimetre), files.range_png)
          .and_then([&] { return WritePng(Levels(ranges.sd_m, ranges, kTenth), files.sd_png); })
          .and_then([&] { return WritePfm(ranges.range_m, ranges, files.range_pfm); })
          .and_then([&] { return WritePfm(ranges.sd_m, ranges, files.sd_pfm); })
          .and_then([&] {
            return WritePng(vision::ConstImageView{view.data(), ranges.width_px, ranges.height_px},
                            files.view_png);
          });
  if (!all) return tl::unexpected(all.error());
  return files;
}

}  // namespace kawara::mapper
