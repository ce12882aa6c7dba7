#include "onboard/mapper/range_files.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gis/model/whole_file.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;
using vision::RangeImage;

static_assert(std::endian::native == std::endian::little, "PFM is written as it lies in memory");

core::Expected<void> WriteWhole(const fs::path& path, const void* data, std::size_t bytes) {
  return gis::WriteWholeFile(path, {static_cast<const char*>(data), bytes});
}

core::Expected<void> WritePng(const cv::Mat& picture, const fs::path& path) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", picture, bytes)) {
    return core::Fail(core::ErrorCode::kIo, "write " + path.string() + ": could not be encoded");
  }
  return WriteWhole(path, bytes.data(), bytes.size());
}

/// In units of `unit_m`; 0 where unknown, 65535 beyond the scale.
cv::Mat Levels(const std::vector<float>& values_m, const RangeImage& size, float unit_m) {
  cv::Mat levels(size.height_px, size.width_px, CV_16UC1);
  for (int v = 0; v < size.height_px; ++v) {
    for (int u = 0; u < size.width_px; ++u) {
      const float value = values_m[size.index(u, v)];
      const float level = std::isnan(value) ? 0.0F : std::clamp(value / unit_m, 1.0F, 65535.0F);
      levels.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(level + 0.5F);
    }
  }
  return levels;
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

/// Inverse range from 1 m (red) to 20 m and more (blue).
cv::Mat View(const RangeImage& ranges) {
  cv::Mat grey(ranges.height_px, ranges.width_px, CV_8UC1), view;
  for (int v = 0; v < ranges.height_px; ++v) {
    for (int u = 0; u < ranges.width_px; ++u) {
      const float range = ranges.range_m[ranges.index(u, v)];
      const float nearness = (1.0F / std::max(range, 1.0F) - 0.05F) / 0.95F;
      grey.at<std::uint8_t>(v, u) =
          std::isnan(range)
              ? 0
              : static_cast<std::uint8_t>(255.0F * std::sqrt(std::clamp(nearness, 0.0F, 1.0F)));
    }
  }
  cv::applyColorMap(grey, view, cv::COLORMAP_TURBO);
  for (int v = 0; v < ranges.height_px; ++v) {
    for (int u = 0; u < ranges.width_px; ++u) {
      if (std::isnan(ranges.range_m[ranges.index(u, v)])) view.at<cv::Vec3b>(v, u) = {0, 0, 0};
    }
  }
  return view;
}

}  // namespace

core::Expected<RangeFiles> WriteRangeFiles(const RangeImage& ranges, const fs::path& folder,
                                           const std::string& name) {
  const RangeFiles files{folder / (name + ".range.png"), folder / (name + ".sd.png"),
                         folder / (name + ".range.pfm"), folder / (name + ".sd.pfm"),
                         folder / (name + ".view.png")};
  constexpr float kMillimetre = 1e-3F, kTenth = 1e-4F;
  const auto all =
      WritePng(Levels(ranges.range_m, ranges, kMillimetre), files.range_png)
          .and_then([&] { return WritePng(Levels(ranges.sd_m, ranges, kTenth), files.sd_png); })
          .and_then([&] { return WritePfm(ranges.range_m, ranges, files.range_pfm); })
          .and_then([&] { return WritePfm(ranges.sd_m, ranges, files.sd_pfm); })
          .and_then([&] { return WritePng(View(ranges), files.view_png); });
  if (!all) return tl::unexpected(all.error());
  return files;
}

}  // namespace kawara::mapper
