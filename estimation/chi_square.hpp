#pragma once
#include <array>
#include <cstddef>

namespace kawara::estimation {

/// A consistent innovation of so many rows (1 to 3) exceeds this once in a thousand times.
constexpr double ChiSquareOneOf1000(int rows) {
  constexpr std::array<double, 3> kQuantiles = {10.83, 13.82, 16.27};
  return kQuantiles[static_cast<std::size_t>(rows - 1)];
}

}  // namespace kawara::estimation
