#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "vision/sides/side_patch.hpp"

namespace kawara::vision {

/// Numbers of the looks worth rectifying: those good for most of the side, and beside them those
/// that are much better for some of it. At most ten, the best one first.
std::vector<std::size_t> WorthRectifying(const SideGrid& grid, std::span<const SideLook> looks);

/// How much of the detail that any of the patches shows each one shows, 0..1: blur takes it away.
std::vector<float> Sharpness(const SideGrid& grid, std::span<const SidePatch> patches);

/// A look and what was made of it.
struct SideCandidate {
  const SideLook& look;
  const SidePatch& patch;
  float sharpness = 1.0F;
};

/// Which candidate shows what.
struct SideChoice {
  static constexpr int kNone = -1;
  std::vector<int> of_node;
  std::vector<std::array<float, 3>> gains;  ///< of each candidate, RGB: to the first one's exposure
  int main = kNone;                         ///< shows most nodes
};

/// The best one for all that it shows at least half as well as any other, then the best one for
/// the rest, and so on.
SideChoice ChooseForNodes(const SideGrid& grid, std::span<const SideCandidate> candidates);

}  // namespace kawara::vision
