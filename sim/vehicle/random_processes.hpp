#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "sim/dice.hpp"

namespace kawara::sim {

/// The seed of one use of randomness: so that one sensor's dice do not depend on how often
/// another's are thrown. FNV-1a over the purpose, mixed by SplitMix64.
inline std::uint64_t SeedOf(std::uint64_t seed, std::string_view purpose) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : purpose) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3ULL;
  return Dice(seed ^ hash).Next();
}

/// Three independent standard normal numbers, in this order on every compiler.
inline Eigen::Vector3d NormalVector(Dice& dice) {
  Eigen::Vector3d v;
  for (double& axis : v) axis = dice.Normal();
  return v;
}

/// A unit's lasting error: normal, but drawn anew beyond two deviations, as makers sort out what is
/// off limits. Its own deviation is 0.88.
inline double DrawnNormal(Dice& dice) {
  double value = dice.Normal();
  while (std::abs(value) > 2.0) value = dice.Normal();
  return value;
}
inline Eigen::Vector3d DrawnVector(Dice& dice) {
  Eigen::Vector3d v;
  for (double& axis : v) axis = DrawnNormal(dice);
  return v;
}

/// Three independent first-order Gauss-Markov processes of standard deviation 1, stationary from
/// the start: autocorrelation exp(-dt / tau). One thread.
class GaussMarkov {
 public:
  GaussMarkov(double tau, Dice& dice) : tau_(tau), value_(NormalVector(dice)) {}
  /// Goes on by `dt`, in the unit of tau.
  const Eigen::Vector3d& Step(double dt, Dice& dice) {
    const double keep = std::exp(-dt / tau_);
    value_ = keep * value_ + std::sqrt(1.0 - keep * keep) * NormalVector(dice);
    return value_;
  }
  const Eigen::Vector3d& value() const { return value_; }

 private:
  double tau_;
  Eigen::Vector3d value_;
};

}  // namespace kawara::sim
