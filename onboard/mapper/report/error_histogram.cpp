#include "onboard/mapper/report/error_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace kawara::mapper {

void ErrorHistogram::Add(double error_m) {
  const double bin = std::floor(error_m * 1e3) + kLimitMm;
  if (bin >= 0.0 && bin < 2.0 * kLimitMm) ++bins_[static_cast<std::size_t>(bin)];
  ++total_;
}

void ErrorHistogram::Add(const ErrorHistogram& other) {
  std::transform(bins_.begin(), bins_.end(), other.bins_.begin(), bins_.begin(), std::plus<>());
  total_ += other.total_;
}

std::uint64_t ErrorHistogram::Count(int from_mm, int to_mm) const {
  const int first = std::clamp(from_mm, -kLimitMm, kLimitMm) + kLimitMm;
  const int last = std::clamp(to_mm, -kLimitMm, kLimitMm) + kLimitMm;
  if (last <= first) return 0;
  return std::accumulate(bins_.begin() + first, bins_.begin() + last, std::uint64_t{0});
}

// [mm, mm + 1) to either side.
std::uint64_t ErrorHistogram::SizeCount(int mm) const {
  return bins_[static_cast<std::size_t>(kLimitMm + mm)] +
         bins_[static_cast<std::size_t>(kLimitMm - 1 - mm)];
}

double ErrorHistogram::MedianSizeM() const {
  if (total_ == 0) return std::numeric_limits<double>::quiet_NaN();
  const double half = 0.5 * static_cast<double>(total_);
  double before = 0.0;
  for (int mm = 0; mm < kLimitMm; ++mm) {
    const auto count = static_cast<double>(SizeCount(mm));
    if (before + count >= half) return 1e-3 * (mm + (half - before) / count);
    before += count;
  }
  return 1e-3 * kLimitMm;
}

int ErrorHistogram::SizeOfShareMm(double share) const {
  const double wanted = share * static_cast<double>(total_);
  double before = 0.0;
  int mm = 0;
  for (; mm < kLimitMm && before < wanted; ++mm) before += static_cast<double>(SizeCount(mm));
  return mm;
}

}  // namespace kawara::mapper
