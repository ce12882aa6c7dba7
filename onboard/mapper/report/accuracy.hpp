#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "onboard/mapper/report/error_histogram.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::mapper {

/// How good distance images are where the truth is known. An error is range minus truth along the
/// pixel's ray; NaN: there was nothing to tell it from.
struct AccuracyFigures {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::uint64_t wanted = 0;  ///< pixels with a true range in the band
  std::uint64_t known = 0;   ///< of them, those with a measured one
  double std_m = kNone;      ///< standard deviation of the errors within 10 % of the truth
  double nmad_m = kNone;     ///< 1.4826 median |error| of all, bias included; 5.93 m: that or more
  double bias_m = kNone;     ///< mean of the errors within 10 %
  double outliers = kNone;   ///< share of the known with an error over 10 %
  double density = kNone;    ///< known / wanted
  double within_2_sd = kNone;  ///< share of the known with an error below 2 stated deviations
};

/// Gathers the accuracy of any number of distance images by bands of true range, in fixed memory:
/// the medians come from histograms of a millimetre. Definitions as in `./run bench stereo`.
/// Source: the paper's Fig. 17-18 (histogram of the distance error, 2-6 m). One thread.
class Accuracy {
 public:
  /// Bounds of the bands [m]; band i holds true ranges in [kEdges[i], kEdges[i + 1]).
  static constexpr std::array<double, 6> kEdgesM{0.0, 2.0, 4.0,
                                                 6.0, 8.0, std::numeric_limits<double>::infinity()};
  static constexpr std::size_t kBands = kEdgesM.size() - 1;
  static constexpr double kOutlier = 0.1;  ///< of the true range

  /// `truth_m`: true range of each pixel, 0 or NaN where unknown. `counted`: pixels that are
  /// judged, not 0; empty: all. Both, unless empty, of the image's size.
  void Add(const vision::RangeImage& ranges, std::span<const float> truth_m,
           std::span<const std::uint8_t> counted = {});

  std::uint64_t images() const { return images_; }
  /// Over bands first..last, both included.
  AccuracyFigures Figures(std::size_t first, std::size_t last) const;
  ErrorHistogram Errors(std::size_t first, std::size_t last) const;

 private:
  struct Band {
    std::uint64_t wanted = 0, near = 0, honest = 0;
    double sum_m = 0.0, square_m2 = 0.0;  ///< of the near
    ErrorHistogram errors;
  };
  std::array<Band, kBands> bands_;
  std::uint64_t images_ = 0;
};

}  // namespace kawara::mapper
