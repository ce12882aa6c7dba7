#pragma once
#include <cstdint>
#include <string_view>

#include "sim/dice.hpp"

namespace kawara::sim {

/// A stream of chance of its own for each purpose, so that adding one thing to a site leaves the
/// others as they are. FNV-1a over the name, then mixed with the seed.
inline std::uint64_t SeedFor(std::uint64_t seed, std::string_view purpose) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : purpose) {
    hash ^= static_cast<std::uint8_t>(c);
    hash *= 0x100000001b3ULL;
  }
  return Dice(seed ^ hash).Next();
}
inline Dice DiceFor(std::uint64_t seed, std::string_view purpose) {
  return Dice(SeedFor(seed, purpose));
}

/// Evenly in (low, high].
inline double Between(Dice& dice, double low, double high) {
  return low + (high - low) * dice.Uniform();
}
/// Evenly among 0..count-1.
inline int Pick(Dice& dice, int count) {
  return static_cast<int>(dice.Next() % static_cast<std::uint64_t>(count));
}
inline bool Chance(Dice& dice, double share) { return dice.Uniform() <= share; }

}  // namespace kawara::sim
