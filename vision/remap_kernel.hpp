#pragma once
#include <cstddef>
#include <cstdint>

#include "vision/remap_table.hpp"

namespace kawara::vision {

struct RemapSource {
  const std::uint8_t* data;
  std::size_t stride_bytes;
  std::size_t size_bytes;
};

/// Computes one band of a target picture: `rows` rows of `runs_per_row` runs each, the first at
/// `target`, each next row `target_stride_bytes` further. RGB8. Chooses the best SIMD target of
/// this machine at the first call. Every target gives the same bytes, of each colour:
///
///   row    = 256 a - floor(256 a wr / 65536) + floor(256 b wr / 65536)    a, b side by side
///   sample = upper - floor(upper wd / 65536) + floor(lower wd / 65536)    in 1/256 of a level
///   mean   = floor(n / 2) + sum of floor(sample (65536 / n) / 65536)      for n > 1 samples only
///   level  = floor((mean + 128) / 256)
///
/// so a constant picture stays constant and the error before the last rounding is under 1/64 of a
/// level.
void RemapBand(const RemapSource& source, const RemapTable::Run* runs, int runs_per_row, int rows,
               const RemapEntry* entries, std::uint8_t* target, std::size_t target_stride_bytes);

/// The same for one plane of samples, by the same arithmetic. `black` stands for every sample
/// outside the source.
void RemapPlaneBand(const RemapSource& source, std::uint8_t black, const RemapTable::Run* runs,
                    int runs_per_row, int rows, const RemapEntry* entries, std::uint8_t* target,
                    std::size_t target_stride_bytes);

}  // namespace kawara::vision
