#pragma once
#include <algorithm>
#include <array>
#include <cmath>

namespace kawara::vision {

/// x + k1 x^3 + k2 x^5 + k3 x^7 + k4 x^9: how lens distortion is written nearly everywhere.
struct OddPolynomial {
  std::array<double, 4> k{};

  bool IsIdentity() const { return k == std::array<double, 4>{}; }

  double Value(double x) const {
    const double s = x * x;
    return x * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
  }

  double Slope(double x) const {
    const double s = x * x;
    return 1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * (7.0 * k[2] + s * 9.0 * k[3])));
  }

  /// The x in [low, high] with Value(x) = value, the nearest end if there is none. The polynomial
  /// must grow over [low, high]. To rounding: Newton's steps, bisection where they leave the
  /// bracket.
  double Solve(double value, double low, double high) const {
    if (IsIdentity()) return std::clamp(value, low, high);
    double x = std::clamp(value, low, high);
    for (int i = 0; i < 100; ++i) {
      const double error = Value(x) - value;
      if (error == 0.0) return x;
      (error > 0.0 ? high : low) = x;
      double next = x - error / Slope(x);
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      const double step = std::abs(next - x);
      x = next;
      if (step <= 1e-16 * std::abs(x)) break;
    }
    return x;
  }
};

}  // namespace kawara::vision
