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
/// this machine at the first call. Every target gives the same bytes:
///   row    = 256 a - floor(256 a wr / 65536) + floor(256 b wr / 65536)      of the upper and lower
///   pixel pair sample = upper - floor(upper wd / 65536) + floor(lower wd / 65536)      level in
///   1/256 mean   = floor(n / 2) + sum of floor(sample (65536 / n) / 65536)        only for n > 1
///   samples level  = floor((mean + 128) / 256)
/// so a constant picture stays constant and the error before the last rounding is under 1/64 of a
/// level.
void RemapBand(const RemapSource& source, const RemapTable::Run* runs, int runs_per_row, int rows,
               const RemapEntry* entries, std::uint8_t* target, std::size_t target_stride_bytes);

}  // namespace kawara::vision
