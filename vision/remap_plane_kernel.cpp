#include <bit>
#include <cstring>

#include "vision/remap_kernel.hpp"

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/remap_plane_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

static_assert(std::endian::native == std::endian::little, "the left sample is a pair's low byte");

HWY_BEFORE_NAMESPACE();
namespace kawara::vision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kRun = RemapTable::kRunPixels;
constexpr std::size_t kEntryWords = sizeof(RemapEntry) / sizeof(std::uint16_t);

HWY_INLINE std::uint32_t LoadPair(const std::uint8_t* from) {
  std::uint16_t pair;
  std::memcpy(&pair, from, sizeof pair);
  return pair;
}

// The four source samples of each entry: upper left and right, lower left and right, as bytes of
// two 16-bit words. Unlike RGB pixels they end where the picture ends: nothing is read beyond it.
HWY_INLINE void Gather(const RemapSource& source, std::uint32_t black, const RemapEntry* entries,
                       std::size_t count, bool at_edge, std::uint16_t* pairs) {
  const std::uint8_t* const upper = source.data;
  const std::uint8_t* const lower = source.data + source.stride_bytes;
  const auto gather = [&](std::size_t i) {
    const std::uint32_t offset = entries[i].offset;
    const std::uint32_t quad = LoadPair(upper + offset) | LoadPair(lower + offset) << 16;
    std::memcpy(pairs + 2 * i, &quad, sizeof quad);
  };
  std::size_t i = 0;
  if (!at_edge) {
    for (; i + 4 <= count; i += 4) {
      gather(i);
      gather(i + 1);
      gather(i + 2);
      gather(i + 3);
    }
  }
  for (; i < count; ++i) {
    if (entries[i].offset != RemapEntry::kOutside) {
      gather(i);
    } else {
      std::memcpy(pairs + 2 * i, &black, sizeof black);
    }
  }
}

// Samples in 1/256 of a level from 16-bit lanes.
template <class D16>
HWY_INLINE hn::Vec<D16> Bilinear(D16 d16, const std::uint16_t* pairs,
                                 const std::uint16_t* entries) {
  hn::Vec<D16> upper, lower, offset_low, offset_high, weight_right, weight_down;
  hn::LoadInterleaved2(d16, pairs, upper, lower);
  hn::LoadInterleaved4(d16, entries, offset_low, offset_high, weight_right, weight_down);
  const auto high_byte = hn::Set(d16, 0xFF00);
  const auto blend = [](auto a, auto b, auto w) {
    return hn::Add(hn::Sub(a, hn::MulHigh(a, w)), hn::MulHigh(b, w));
  };
  const auto upper_row = blend(hn::ShiftLeft<8>(upper), hn::And(upper, high_byte), weight_right);
  const auto lower_row = blend(hn::ShiftLeft<8>(lower), hn::And(lower, high_byte), weight_right);
  return blend(upper_row, lower_row, weight_down);
}

void PlaneRow(const RemapSource& source, std::uint8_t black, const RemapTable::Run* runs,
              int run_count, const RemapEntry* entries, std::uint8_t* target) {
  const hn::ScalableTag<std::uint16_t> d16;
  const hn::RebindToSigned<decltype(d16)> d16_signed;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const std::size_t lanes = hn::Lanes(d16);
  const auto half_level = hn::Set(d16, 128);
  const std::uint32_t black_quad = black * 0x01010101U;
  HWY_ALIGN std::uint16_t pairs[kRun * 2] = {};
  HWY_ALIGN std::uint16_t weights[kRun * kEntryWords] = {};
  HWY_ALIGN std::uint16_t mean[kRun];
  HWY_ALIGN std::uint8_t levels[kRun];

  for (int r = 0; r < run_count; ++r) {
    const RemapTable::Run& run = runs[r];
    const std::size_t count = run.pixels;
    const std::size_t samples = std::size_t{run.samples_u} * run.samples_v;
    if (samples == 0) {
      std::memset(target, black, count);
      target += count;
      continue;
    }
    const RemapEntry* sample = entries + run.first_entry;
    const auto share = hn::Set(d16, static_cast<std::uint16_t>(samples > 1 ? 65536 / samples : 0));
    for (std::size_t s = 0; s < samples; ++s, sample += count) {
      Gather(source, black_quad, sample, count, run.at_edge, pairs);
      std::memcpy(weights, sample, count * sizeof(RemapEntry));
      for (std::size_t i = 0; i < count; i += lanes) {
        auto level = Bilinear(d16, pairs + 2 * i, weights + kEntryWords * i);
        if (samples > 1) {
          const auto before = s == 0 ? hn::Set(d16, static_cast<std::uint16_t>(samples / 2))
                                     : hn::Load(d16, mean + i);
          level = hn::Add(before, hn::MulHigh(level, share));
          if (s + 1 < samples) {
            hn::Store(level, d16, mean + i);
            continue;
          }
        }
        const auto rounded = hn::ShiftRight<8>(hn::Add(level, half_level));
        hn::Store(hn::DemoteTo(d8, hn::BitCast(d16_signed, rounded)), d8, levels + i);
      }
    }
    std::memcpy(target, levels, count);
    target += count;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision {

HWY_EXPORT(PlaneRow);

void RemapPlaneBand(const RemapSource& source, std::uint8_t black, const RemapTable::Run* runs,
                    int runs_per_row, int rows, const RemapEntry* entries, std::uint8_t* target,
                    std::size_t target_stride_bytes) {
  const auto row_function = HWY_DYNAMIC_DISPATCH(PlaneRow);
  for (int row = 0; row < rows; ++row) {
    row_function(source, black, runs, runs_per_row, entries, target);
    runs += runs_per_row;
    target += target_stride_bytes;
  }
}

}  // namespace kawara::vision
#endif  // HWY_ONCE
