#include "vision/remap_kernel.hpp"

#include <bit>
#include <cstring>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/remap_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

static_assert(std::endian::native == std::endian::little, "RemapEntry is read as a 64-bit lane");

HWY_BEFORE_NAMESPACE();
namespace kawara::vision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

// Machines without vectors, and the readable form of the arithmetic.
HWY_INLINE std::uint32_t Blend(std::uint32_t a, std::uint32_t b, std::uint32_t weight) {
  return a - (a * weight >> 16) + (b * weight >> 16);
}

void Row(const RemapSource& source, const RemapTable::Run* runs, int run_count,
         const RemapEntry* entries, std::uint8_t* target) {
  for (int r = 0; r < run_count; ++r) {
    const RemapTable::Run& run = runs[r];
    const std::uint32_t samples = std::uint32_t{run.samples_u} * run.samples_v;
    for (std::size_t i = 0; i < run.pixels; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint32_t mean = samples > 1 ? samples / 2 : 0;
        for (std::size_t s = 0; s < samples; ++s) {
          const RemapEntry& entry = entries[run.first_entry + s * run.pixels + i];
          if (entry.offset == RemapEntry::kOutside) continue;
          const std::uint8_t* upper = source.data + entry.offset + c;
          const std::uint8_t* lower = upper + source.stride_bytes;
          const std::uint32_t level =
              Blend(Blend(256U * upper[0], 256U * upper[3], entry.weight_right),
                    Blend(256U * lower[0], 256U * lower[3], entry.weight_right), entry.weight_down);
          mean += samples > 1 ? level * (65536 / samples) >> 16 : level;
        }
        *target++ = static_cast<std::uint8_t>((mean + 128) >> 8);
      }
    }
  }
}

#else

constexpr std::size_t kRun = RemapTable::kRunPixels;

// Byte shuffles within 128 bits = two pixels of 8 bytes; 0x80 gives zero.
alignas(16) constexpr std::uint8_t kLeftPixel[16] = {0x80, 0, 0x80, 1, 0x80, 2,  0x80, 0x80,
                                                     0x80, 8, 0x80, 9, 0x80, 10, 0x80, 0x80};
alignas(16) constexpr std::uint8_t kRightPixel[16] = {0x80, 3,  0x80, 4,  0x80, 5,  0x80, 0x80,
                                                      0x80, 11, 0x80, 12, 0x80, 13, 0x80, 0x80};
alignas(16) constexpr std::uint8_t kWeightRight[16] = {4,  5,  4,  5,  4,  5,  4,  5,
                                                       12, 13, 12, 13, 12, 13, 12, 13};
alignas(16) constexpr std::uint8_t kWeightDown[16] = {6,  7,  6,  7,  6,  7,  6,  7,
                                                      14, 15, 14, 15, 14, 15, 14, 15};
alignas(16) constexpr std::uint8_t kHighBytes[16] = {
    1, 3, 5, 9, 11, 13, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80};

// One 64-bit lane a pixel: the two source pixels side by side in the upper and in the lower row.
struct Gathered {
  HWY_ALIGN std::uint64_t upper[kRun];
  HWY_ALIGN std::uint64_t lower[kRun];
};

HWY_INLINE std::uint64_t Load8(const std::uint8_t* from) {
  std::uint64_t bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return bytes;
}

// The last pixel pair of the picture ends two bytes before a full 8-byte read would.
HWY_INLINE std::uint64_t Load8Within(const RemapSource& source, std::size_t offset) {
  const std::size_t last = source.size_bytes - sizeof(std::uint64_t);
  if (offset <= last) return Load8(source.data + offset);
  return Load8(source.data + last) >> (8 * (offset - last));
}

void Gather(const RemapSource& source, const RemapEntry* entries, std::size_t count, bool at_edge,
            Gathered& g) {
  const std::uint8_t* const upper = source.data;
  const std::uint8_t* const lower = source.data + source.stride_bytes;
  if (!at_edge) {
    for (std::size_t i = 0; i < count; ++i) {
      g.upper[i] = Load8(upper + entries[i].offset);
      g.lower[i] = Load8(lower + entries[i].offset);
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t offset = entries[i].offset;
    const bool inside = offset != RemapEntry::kOutside;
    g.upper[i] = inside ? Load8Within(source, offset) : 0;
    g.lower[i] = inside ? Load8Within(source, offset + source.stride_bytes) : 0;
  }
}

// Level in 1/256 of the pixels of one 8-byte lane each: four 16-bit lanes R G B -.
template <class D8, class D16>
HWY_INLINE hn::Vec<D16> Bilinear(D8 d8, D16 d16, const std::uint64_t* upper_lanes,
                                 const std::uint64_t* lower_lanes, const RemapEntry* entries) {
  const auto left = hn::LoadDup128(d8, kLeftPixel);
  const auto right = hn::LoadDup128(d8, kRightPixel);
  const auto upper = hn::Load(d8, reinterpret_cast<const std::uint8_t*>(upper_lanes));
  const auto lower = hn::Load(d8, reinterpret_cast<const std::uint8_t*>(lower_lanes));
  const auto weights = hn::LoadU(d8, reinterpret_cast<const std::uint8_t*>(entries));
  const auto wr = hn::BitCast(d16, hn::TableLookupBytes(weights, hn::LoadDup128(d8, kWeightRight)));
  const auto wd = hn::BitCast(d16, hn::TableLookupBytes(weights, hn::LoadDup128(d8, kWeightDown)));
  const auto blend = [](auto a, auto b, auto w) {
    return hn::Add(hn::Sub(a, hn::MulHigh(a, w)), hn::MulHigh(b, w));
  };
  const auto upper_row = blend(hn::BitCast(d16, hn::TableLookupBytesOr0(upper, left)),
                               hn::BitCast(d16, hn::TableLookupBytesOr0(upper, right)), wr);
  const auto lower_row = blend(hn::BitCast(d16, hn::TableLookupBytesOr0(lower, left)),
                               hn::BitCast(d16, hn::TableLookupBytesOr0(lower, right)), wr);
  return blend(upper_row, lower_row, wd);
}

// Two pixels lie in the first six of every 16 bytes: close the gaps. Never writes past pixel
// `count`.
void Pack(const std::uint8_t* pairs, std::size_t count, std::uint8_t* target) {
  std::size_t i = 0;
  // The two bytes too many of a pair fall on the pixel after it, which is written next.
  for (; i + 2 < count; i += 2) std::memcpy(target + 3 * i, pairs + 8 * i, 8);
  for (; i < count; i += 2) std::memcpy(target + 3 * i, pairs + 8 * i, i + 1 < count ? 6 : 3);
}

void Row(const RemapSource& source, const RemapTable::Run* runs, int run_count,
         const RemapEntry* entries, std::uint8_t* target) {
  const hn::ScalableTag<std::uint8_t> d8;
  const hn::Repartition<std::uint16_t, decltype(d8)> d16;
  const std::size_t lanes = hn::Lanes(d8) / 8;  // pixels a vector
  const auto half_level = hn::Set(d16, 128);
  const auto high_bytes = hn::LoadDup128(d8, kHighBytes);
  Gathered g;
  std::memset(&g, 0, sizeof g);
  HWY_ALIGN std::uint16_t mean[kRun * 4];
  HWY_ALIGN std::uint8_t pairs[kRun * 8];
  RemapEntry tail[kRun];  // weights of a short run: whole vectors must not read past the table

  for (int r = 0; r < run_count; ++r) {
    const RemapTable::Run& run = runs[r];
    const std::size_t count = run.pixels;
    const std::size_t samples = std::size_t{run.samples_u} * run.samples_v;
    if (samples == 0) {
      std::memset(target, 0, count * 3);
      target += count * 3;
      continue;
    }
    const RemapEntry* sample = entries + run.first_entry;
    const auto share = hn::Set(d16, static_cast<std::uint16_t>(samples > 1 ? 65536 / samples : 0));
    for (std::size_t s = 0; s < samples; ++s, sample += count) {
      Gather(source, sample, count, run.at_edge, g);
      const RemapEntry* weights = sample;
      if (count < kRun) {
        std::memcpy(static_cast<void*>(tail), sample, count * sizeof(RemapEntry));
        weights = tail;
      }
      for (std::size_t i = 0; i < count; i += lanes) {
        auto level = Bilinear(d8, d16, g.upper + i, g.lower + i, weights + i);
        if (samples > 1) {
          const auto before = s == 0 ? hn::Set(d16, static_cast<std::uint16_t>(samples / 2))
                                     : hn::Load(d16, mean + 4 * i);
          level = hn::Add(before, hn::MulHigh(level, share));
          if (s + 1 < samples) {
            hn::Store(level, d16, mean + 4 * i);
            continue;
          }
        }
        const auto rounded = hn::BitCast(d8, hn::Add(level, half_level));
        hn::Store(hn::TableLookupBytesOr0(rounded, high_bytes), d8, pairs + 8 * i);
      }
    }
    Pack(pairs, count, target);
    target += count * 3;
  }
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision {

HWY_EXPORT(Row);

void RemapBand(const RemapSource& source, const RemapTable::Run* runs, int runs_per_row, int rows,
               const RemapEntry* entries, std::uint8_t* target, std::size_t target_stride_bytes) {
  const auto row_function = HWY_DYNAMIC_DISPATCH(Row);
  for (int row = 0; row < rows; ++row) {
    row_function(source, runs, runs_per_row, entries, target);
    runs += runs_per_row;
    target += target_stride_bytes;
  }
}

}  // namespace kawara::vision
#endif  // HWY_ONCE
