#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace kawara::sim {

/// Raw values at a steady pitch made smooth: the uniform quintic B-spline that has them as its
/// control values. Four times continuously differentiable; between the least and the greatest raw
/// value, with slopes between the raw ones (no overshoot); straight rows come out unchanged; a step
/// is spread over three pitches to either side (standard deviation of the kernel: 0.71 pitches).
/// Outside the raw values the first and last hold. Immutable; any thread.
/// Source: C. de Boor, A Practical Guide to Splines, on B-splines with equal knots.
class SmoothSeries {
 public:
  /// Value and first three derivatives by the argument.
  using Jet = std::array<double, 4>;

  SmoothSeries() : SmoothSeries({0.0}, 1.0) {}
  /// values[i] belongs to the argument i * pitch; at least one.
  SmoothSeries(std::vector<double> values, double pitch)
      : values_(std::move(values)), pitch_(pitch) {}

  Jet At(double argument) const {
    const double limit = static_cast<double>(values_.size()) + 3.0;
    const double knot = std::clamp(argument / pitch_, -4.0, limit);
    const double whole = std::floor(knot);
    return AtKnot(static_cast<std::ptrdiff_t>(whole), knot - whole);
  }
  double pitch() const { return pitch_; }
  std::size_t size() const { return values_.size(); }

 private:
  Jet AtKnot(std::ptrdiff_t knot, double x) const {
    // Weights of the six control values around as polynomials of x, times 120.
    static constexpr std::array<std::array<double, 6>, 6> kWeights{{{1, -5, 10, -10, 5, -1},
                                                                    {26, -50, 20, 20, -20, 5},
                                                                    {66, 0, -60, 0, 30, -10},
                                                                    {26, 50, 20, -20, -20, 10},
                                                                    {1, 5, 10, 10, 5, -5},
                                                                    {0, 0, 0, 0, 0, 1}}};
    // The values as differences to one of them: sums of equal values are then exactly zero.
    const auto value = [&](std::ptrdiff_t i) {
      const auto last = static_cast<std::ptrdiff_t>(values_.size()) - 1;
      return values_[static_cast<std::size_t>(std::clamp(i, std::ptrdiff_t{0}, last))];
    };
    const double base = value(knot);
    std::array<double, 6> c{};
    for (std::ptrdiff_t j = 0; j < 6; ++j) {
      const double difference = value(knot + j - 2) - base;
      if (difference == 0.0) continue;
      for (std::size_t power = 0; power < 6; ++power)
        c[power] += kWeights[static_cast<std::size_t>(j)][power] * difference;
    }
    const double k1 = 1.0 / (120.0 * pitch_);
    const double k2 = k1 / pitch_;
    const double k3 = k2 / pitch_;
    return {base + (((((c[5] * x + c[4]) * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0]) / 120.0,
            k1 * ((((5 * c[5] * x + 4 * c[4]) * x + 3 * c[3]) * x + 2 * c[2]) * x + c[1]),
            k2 * (((20 * c[5] * x + 12 * c[4]) * x + 6 * c[3]) * x + 2 * c[2]),
            k3 * ((60 * c[5] * x + 24 * c[4]) * x + 6 * c[3])};
  }

  std::vector<double> values_;
  double pitch_;
};

}  // namespace kawara::sim
