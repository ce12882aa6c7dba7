#pragma once
#include <span>
#include <vector>

namespace kawara::vision {

/// Where a side of a box lies, seen along its normal.
struct SidePeak {
  double at_m = 0.0;         ///< of the side
  double sharpness = 0.0;    ///< density there over the mean density: a wall has 3 and more
  double outermost_m = 0.0;  ///< beyond which one percent of the votes lies
  double innermost_m = 0.0;  ///< the same of the other end
};

/// A side of things that lie at `at_m` along an axis, outwards positive, each with a weight: the
/// strongest peak of their smoothed density in the outer `depth_m`.
class SideProfile {
 public:
  /// `step_m` of the histogram, `smooth_m` standard deviation of the kernel.
  SideProfile(double step_m, double smooth_m) : step_m_(step_m), smooth_m_(smooth_m) {}
  /// `at_m` and `weight` of the same length, not empty. Reuses its memory.
  void Fill(std::span<const double> at_m, std::span<const double> weight);
  SidePeak Upper(double depth_m) const { return Peak(depth_m, true); }
  SidePeak Lower(double depth_m) const { return Peak(depth_m, false); }
  /// Where the density falls to half of what it typically is: the end of a surface seen from the
  /// side.
  double UpperEdge() const { return Edge(true); }
  double LowerEdge() const { return Edge(false); }

 private:
  SidePeak Peak(double depth_m, bool upper) const;
  double Edge(bool upper) const;
  double Quantile(double share) const;

  double step_m_, smooth_m_;
  double first_m_ = 0.0;  ///< of the histogram's first bin
  double sum_ = 0.0;
  std::vector<double> raw_, density_;
};

}  // namespace kawara::vision
