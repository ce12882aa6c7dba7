#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/support/test_doughnut.hpp"
#include "vision/image.hpp"
#include "vision/yuv420.hpp"

namespace kawara::vision {

inline std::vector<std::uint8_t> ReadTestFile(const std::string& path_in_repository) {
  std::ifstream file(std::string(KAWARA_SOURCE_DIR) + "/" + path_in_repository, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A picture that owns its pixels.
struct TestImage {
  TestImage(int width_px, int height_px)
      : bytes(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3),
        width(width_px),
        height(height_px) {}
  explicit TestImage(const ConstImageView& view) : TestImage(view.width_px, view.height_px) {
    bytes.assign(view.data, view.data + view.size_bytes());
  }
  ImageView view() { return {bytes.data(), width, height}; }
  ConstImageView view() const { return {bytes.data(), width, height}; }
  std::uint8_t* at(int u, int v) { return view().row(v) + 3 * u; }
  const std::uint8_t* at(int u, int v) const { return view().row(v) + 3 * u; }
  void Fill(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      bytes[i] = r;
      bytes[i + 1] = g;
      bytes[i + 2] = b;
    }
  }
  std::vector<std::uint8_t> bytes;
  int width, height;
};

inline TestImage NoiseImage(int width_px, int height_px, unsigned seed) {
  TestImage image(width_px, height_px);
  std::mt19937 random(seed);
  for (auto& byte : image.bytes) byte = static_cast<std::uint8_t>(random());
  return image;
}

/// Smooth colours with all frequencies up to about one wave in 12 pixels: survives resampling.
inline TestImage WaveImage(int width_px, int height_px) {
  TestImage image(width_px, height_px);
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      for (int c = 0; c < 3; ++c) {
        const double wave =
            std::sin(0.11 * u + 0.07 * v * (c + 1)) + std::cos(0.05 * u * (c + 1) - 0.13 * v);
        image.at(u, v)[c] = static_cast<std::uint8_t>(std::lround(127.5 + 55.0 * wave));
      }
    }
  }
  return image;
}

inline double Psnr(const ConstImageView& a, const ConstImageView& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size_bytes(); ++i) {
    const double difference = static_cast<double>(a.data[i]) - b.data[i];
    sum += difference * difference;
  }
  return 10.0 *
         std::log10(255.0 * 255.0 * static_cast<double>(a.size_bytes()) / std::max(sum, 1e-9));
}

inline double PlanePsnr(const ConstPlaneView& a, const ConstPlaneView& b) {
  double sum = 0.0;
  for (int v = 0; v < a.height_px; ++v) {
    for (int u = 0; u < a.width_px; ++u) {
      const double difference = static_cast<double>(a.row(v)[u]) - b.row(v)[u];
      sum += difference * difference;
    }
  }
  return 10.0 * std::log10(255.0 * 255.0 * a.width_px * a.height_px / std::max(sum, 1e-9));
}

inline double PlaneMean(const ConstPlaneView& plane) {
  double sum = 0.0;
  for (int v = 0; v < plane.height_px; ++v) {
    for (int u = 0; u < plane.width_px; ++u) sum += plane.row(v)[u];
  }
  return sum / plane.width_px / plane.height_px;
}

}  // namespace kawara::vision
