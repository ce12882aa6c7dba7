#include "sim/evaluate/range_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>

namespace kawara::sim {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kBins = 40;
constexpr double kBin_m = 0.05;

float FromMillimetres(std::uint16_t mm) {
  if (mm == 0) return kNan;
  return mm == 65535 ? kInfinity : static_cast<float>(mm) * 1e-3F;
}

}  // namespace

core::Expected<RangeImage> ReadRangeImage(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    return core::Fail(core::ErrorCode::kNotFound, path + ": no such file");
  }
  const cv::Mat picture = cv::imread(path, cv::IMREAD_UNCHANGED);
  const bool millimetres = picture.type() == CV_16UC1;
  if (picture.empty() || (!millimetres && picture.type() != CV_32FC1)) {
    return core::Fail(core::ErrorCode::kFormat,
                      path + ": not a range image (PNG of 16 bits, PFM or TIFF of floats)");
  }
  RangeImage image{picture.cols, picture.rows, {}};
  image.range_m.reserve(static_cast<std::size_t>(picture.cols) *
                        static_cast<std::size_t>(picture.rows));
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      image.range_m.push_back(millimetres ? FromMillimetres(picture.at<std::uint16_t>(v, u))
                                          : picture.at<float>(v, u));
    }
  }
  return image;
}

core::Expected<void> RangeErrors::Add(const RangeImage& truth, const RangeImage& result) {
  if (truth.width_px != result.width_px || truth.height_px != result.height_px) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "range images of " + std::to_string(truth.width_px) + " x " +
                          std::to_string(truth.height_px) + " and " +
                          std::to_string(result.width_px) + " x " +
                          std::to_string(result.height_px) + " pixels");
  }
  ++pictures_;
  for (std::size_t i = 0; i < truth.range_m.size(); ++i) {
    const auto right_m = static_cast<double>(truth.range_m[i]);
    const auto got_m = static_cast<double>(result.range_m[i]);
    if (std::isinf(right_m)) {
      if (std::isfinite(got_m)) ++ranges_in_sky_;
      continue;
    }
    const auto band = std::find_if(bands_.begin(), bands_.end(), [right_m](const Band& b) {
      return right_m >= b.from_m && right_m < b.to_m;
    });
    if (band == bands_.end()) continue;
    ++band->seen;
    if (std::isfinite(got_m)) band->errors_m.push_back(got_m - right_m);
  }
  return {};
}

ErrorReport RangeErrors::Report() const {
  ErrorReport report;
  for (const Band& band : bands_) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%g-%g m", band.from_m, band.to_m);
    report.Add(name.data(), "m", Summarise(band.errors_m));
  }
  for (const Band& band : bands_) {
    if (band.seen == 0) continue;
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%g-%g m", band.from_m, band.to_m);
    const auto n = static_cast<double>(band.errors_m.size());
    const auto outliers =
        static_cast<double>(std::count_if(band.errors_m.begin(), band.errors_m.end(),
                                          [](double e) { return std::abs(e) > kOutlier_m; }));
    report.Add(std::string(name.data()) + " with a range", "share",
               n / static_cast<double>(band.seen));
    if (n > 0) report.Add(std::string(name.data()) + " off by > 0.5 m", "share", outliers / n);
  }
  report.Add("ranges where there is sky", "pixels", static_cast<double>(ranges_in_sky_));
  report.Add("pictures", "pictures", static_cast<double>(pictures_));
  return report;
}

std::string RangeErrors::HistogramCsv() const {
  std::array<std::size_t, kBins> counts{};
  for (const Band& band : bands_) {
    if (band.from_m != 2.0) continue;
    for (const double e : band.errors_m) {
      const double bin = std::floor((e + kBins * kBin_m / 2) / kBin_m);
      counts[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))] += 1;
    }
  }
  std::string csv = "from_m,to_m,count\n";
  for (int i = 0; i < kBins; ++i) {
    std::array<char, 64> line{};
    const double from_m = (i - kBins / 2) * kBin_m;
    std::snprintf(line.data(), line.size(), "%.2f,%.2f,%zu\n", from_m, from_m + kBin_m,
                  counts[static_cast<std::size_t>(i)]);
    csv += line.data();
  }
  return csv;
}

}  // namespace kawara::sim
