#include "onboard/mapper/report/accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"

namespace kawara::mapper {

void Accuracy::Add(const vision::RangeImage& ranges, std::span<const float> truth_m,
                   std::span<const std::uint8_t> counted) {
  CORE_CHECK(truth_m.size() == ranges.range_m.size());
  CORE_CHECK(counted.empty() || counted.size() == truth_m.size());
  ++images_;
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    const auto truth = static_cast<double>(truth_m[i]);
    if (!(truth > 0.0) || !std::isfinite(truth)) continue;
    if (!counted.empty() && counted[i] == 0) continue;
    const auto* const above = std::upper_bound(kEdgesM.begin(), kEdgesM.end() - 1, truth);
    Band& band = bands_[static_cast<std::size_t>(above - kEdgesM.begin()) - 1];
    ++band.wanted;
    const auto range = static_cast<double>(ranges.range_m[i]);
    if (std::isnan(range)) continue;
    const double error = range - truth;
    band.errors.Add(error);
    if (std::abs(error) < 2.0 * static_cast<double>(ranges.sd_m[i])) ++band.honest;
    if (std::abs(error) > kOutlier * truth) continue;
    ++band.near;
    band.sum_m += error;
    band.square_m2 += error * error;
  }
}

AccuracyFigures Accuracy::Figures(std::size_t first, std::size_t last) const {
  CORE_CHECK(first <= last && last < kBands);
  AccuracyFigures figures;
  double near = 0.0, honest = 0.0, sum_m = 0.0, square_m2 = 0.0;
  for (std::size_t i = first; i <= last; ++i) {
    figures.wanted += bands_[i].wanted;
    figures.known += bands_[i].errors.total();
    near += static_cast<double>(bands_[i].near);
    honest += static_cast<double>(bands_[i].honest);
    sum_m += bands_[i].sum_m;
    square_m2 += bands_[i].square_m2;
  }
  const auto known = static_cast<double>(figures.known);
  if (figures.wanted > 0) figures.density = known / static_cast<double>(figures.wanted);
  if (figures.known > 0) {
    constexpr double kSdOfMedian = 1.4826;  // of a normal distribution
    figures.nmad_m = kSdOfMedian * Errors(first, last).MedianSizeM();
    figures.outliers = (known - near) / known;
    figures.within_2_sd = honest / known;
  }
  if (near > 0.0) {
    figures.bias_m = sum_m / near;
    figures.std_m = std::sqrt(std::max(0.0, square_m2 / near - figures.bias_m * figures.bias_m));
  }
  return figures;
}

ErrorHistogram Accuracy::Errors(std::size_t first, std::size_t last) const {
  CORE_CHECK(first <= last && last < kBands);
  ErrorHistogram errors;
  for (std::size_t i = first; i <= last; ++i) errors.Add(bands_[i].errors);
  return errors;
}

}  // namespace kawara::mapper
