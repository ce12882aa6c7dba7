#pragma once
#include <cstdint>
#include <vector>

namespace kawara::mapper {

/// Signed errors counted in bins of a millimetre up to 4 m either way, so that medians of any
/// number of errors take the same memory. NaN is not to be added. One thread.
class ErrorHistogram {
 public:
  static constexpr int kLimitMm = 4000;

  ErrorHistogram() : bins_(static_cast<std::size_t>(2 * kLimitMm), 0) {}

  void Add(double error_m);
  void Add(const ErrorHistogram& other);

  std::uint64_t total() const { return total_; }
  /// Errors in [from_mm, to_mm), within the limits.
  std::uint64_t Count(int from_mm, int to_mm) const;
  /// Of the sizes of all errors, good to a millimetre; NaN if there are none, 4 m if it is more.
  double MedianSizeM() const;
  /// The smallest size [mm] that a share of at least `share` (0..1) of all errors stays below.
  int SizeOfShareMm(double share) const;

 private:
  std::uint64_t SizeCount(int mm) const;

  std::vector<std::uint64_t> bins_;  ///< bin i: errors in [i - kLimitMm, i + 1 - kLimitMm) mm
  std::uint64_t total_ = 0;          ///< with those beyond the limits, which are in no bin
};

}  // namespace kawara::mapper
