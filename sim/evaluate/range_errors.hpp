#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/evaluate/error_statistics.hpp"

namespace kawara::sim {

/// A picture of distances along the rays of its pixels; NaN: unknown, infinity: sky.
struct RangeImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> range_m;  ///< row by row
};

/// PNG of 16 bits: millimetres, 0 unknown, 65535 beyond. PFM and TIFF of floats: metres. Errors:
/// kNotFound, kFormat.
core::Expected<RangeImage> ReadRangeImage(const std::string& path);

/// Errors of ranges, gathered over many pictures, in bands of the TRUE range. The band 2..6 m is
/// that of the paper's Fig. 18, for which a histogram is kept as well.
class RangeErrors {
 public:
  /// kInvalidArgument: sizes differ.
  core::Expected<void> Add(const RangeImage& truth, const RangeImage& result);
  /// Per band: statistics, share of the pixels with a result, share of results off by more than 0.5
  /// m.
  ErrorReport Report() const;
  /// Fig. 18: lines "from_m,to_m,count" of the errors within 2..6 m, bins of 50 mm from -1 to 1 m,
  /// the outermost bins holding what lies beyond.
  std::string HistogramCsv() const;

  static constexpr double kOutlier_m = 0.5;

 private:
  struct Band {
    double from_m, to_m;
    std::size_t seen = 0;  ///< true ranges in the band
    std::vector<double> errors_m;
  };
  std::vector<Band> bands_{
      {0, 2, 0, {}}, {2, 6, 0, {}}, {6, 10, 0, {}}, {10, 20, 0, {}}, {20, 50, 0, {}}};
  std::size_t ranges_in_sky_ = 0;
  std::size_t pictures_ = 0;
};

}  // namespace kawara::sim
