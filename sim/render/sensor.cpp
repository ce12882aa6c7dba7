#include "sim/render/sensor.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::sim {
namespace {

constexpr int kSrgbSteps = 16384;
constexpr int kQuantileBits = 12;  // a table that stays in the nearest cache
constexpr int kQuantiles = 1 << kQuantileBits;

// Source: IEC 61966-2-1.
double SrgbFromLinear(double x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

double NormalCdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

std::uint64_t Mix64(std::uint64_t z) {  // finalizer of SplitMix64, as in sim/dice.hpp
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Sensor::Sensor(const SensorSettings& settings)
    : settings_(settings),
      normal_(static_cast<std::size_t>(kQuantiles)),
      srgb_(static_cast<std::size_t>(kSrgbSteps) + 1) {
  if (settings.full_well_e > 0.0) {
    inverse_well_ = static_cast<float>(1.0 / settings.full_well_e);
    const double share = settings.read_noise_e / settings.full_well_e;
    read_share_squared_ = static_cast<float>(share * share);
  }
  for (int i = 0; i <= kSrgbSteps; ++i) {
    srgb_[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(
        std::lround(255.0 * SrgbFromLinear(static_cast<double>(i) / kSrgbSteps)));
  }
  // Middle of each of the equally likely slices, by bisection.
  for (int i = 0; i < kQuantiles; ++i) {
    const double wanted = (i + 0.5) / kQuantiles;
    double low = -6.0;
    double high = 6.0;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (NormalCdf(middle) < wanted ? low : high) = middle;
    }
    normal_[static_cast<std::size_t>(i)] = static_cast<float>(0.5 * (low + high));
  }
}

double Sensor::GainFor(double mean_light) const {
  if (!settings_.automatic) return settings_.gain;
  const double wanted = settings_.target / std::max(mean_light, 1e-9);
  return std::clamp(wanted, settings_.gain_min, std::max(settings_.gain_min, settings_.gain_max));
}

void Sensor::Expose(const std::array<float, 3>& signal, std::uint64_t frame_seed,
                    std::uint32_t pixel_index, std::uint8_t* rgb) const {
  std::uint64_t bits = Mix64(frame_seed * 0x9e3779b97f4a7c15ULL + pixel_index);
  for (std::size_t c = 0; c < 3; ++c) {
    float x = std::clamp(signal[c], 0.0F, 4.0F);
    if (inverse_well_ > 0.0F) {
      const float sigma = std::sqrt(x * inverse_well_ + read_share_squared_);
      x += sigma * normal_[static_cast<std::size_t>(bits & (kQuantiles - 1U))];
      bits >>= kQuantileBits;
    }
    const float step = std::clamp(x, 0.0F, 1.0F) * static_cast<float>(kSrgbSteps) + 0.5F;
    rgb[c] = srgb_[static_cast<std::size_t>(step)];
  }
}

}  // namespace kawara::sim
