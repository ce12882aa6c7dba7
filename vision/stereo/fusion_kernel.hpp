#pragma once
#include <cstddef>

/// The inner loop of range fusion (range_fusion.hpp says what it does), compiled for every SIMD
/// target (Highway).
namespace kawara::vision::fusion {

constexpr std::size_t kBlock = 16;
constexpr std::size_t kMostSources = 16;

struct Source {
  const float* range_m;  ///< NaN: unknown
  const float* sd_m;
  float direction[3];  ///< of the baseline, unit
};

struct Rules {
  float agreement_square;
  float directed, alike;  ///< parts of the variance that are shared
  float alone_square;     ///< on the variance of a lone estimate
  float largest_relative_sd;
};

/// [pixels], a multiple of kBlock, of each source (2 to kMostSources, the preferred first).
void Fuse(const Source* sources, std::size_t count, const Rules& rules, std::size_t pixels,
          float* range_m, float* sd_m);

}  // namespace kawara::vision::fusion
