#pragma once
#include <cmath>
#include <cstdint>

#include "core/geodesy.hpp"

namespace kawara::sim {

/// Random numbers that are the same on every machine and library for a seed
/// (std::normal_distribution is not). SplitMix64 (public domain algorithm by Sebastiano Vigna). One
/// thread.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  /// In (0, 1].
  double Uniform() { return static_cast<double>((Next() >> 11) + 1) * 0x1.0p-53; }
  /// Mean 0, standard deviation 1 (Box-Muller; one of its two values is thrown away for
  /// simplicity).
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(Uniform()));  // first: operands have no order
    return radius * std::cos(2.0 * core::kPi * Uniform());
  }
  /// Mean 1, never negative: the shape of queueing delays.
  double Exponential() { return -std::log(Uniform()); }

 private:
  std::uint64_t state_;
};

}  // namespace kawara::sim
