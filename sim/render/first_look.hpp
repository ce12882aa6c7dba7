#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "sim/render/noise2.hpp"

namespace kawara::sim {

/// What the rays through the pixels' centres saw at the middle of the exposure. A later ray that
/// meets the same surface between those places needs no shading of its own: the light there is
/// known from the pixels round it. Written by many threads, each its pixels; then read by any.
class FirstLook {
 public:
  /// Of a pixel without a ray; no surface has it (nor the sky).
  static constexpr std::uint32_t kNothing = 2;

  FirstLook(int width_px, int height_px)
      : width_px_(width_px),
        height_px_(height_px),
        pixels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)),
        blocks_across_((width_px + kBlock - 1) / kBlock),
        block_keys_(static_cast<std::size_t>(blocks_across_) *
                    static_cast<std::size_t>(block_rows())) {}

  void Set(int u, int v, const Eigen::Array3f& light, std::uint32_t surface_key) {
    pixels_[Index(u, v)] = {{light[0], light[1], light[2]}, surface_key};
  }
  Eigen::Array3f LightAt(int u, int v) const {
    const Pixel& pixel = pixels_[Index(u, v)];
    return {pixel.light[0], pixel.light[1], pixel.light[2]};
  }
  /// kNothing outside the picture.
  std::uint32_t KeyAt(int u, int v) const {
    return Inside(u, v) ? pixels_[Index(u, v)].surface_key : kNothing;
  }

  /// Finds what Alone() asks, for a row of blocks; when all pixels are set.
  int block_rows() const { return (height_px_ + kBlock - 1) / kBlock; }
  void SumUpBlocks(int row) {
    for (int column = 0; column < blocks_across_; ++column) {
      const std::uint32_t key = KeyAt(kBlock * column, kBlock * row);
      bool same = true;
      for (int v = kBlock * row; v < std::min(kBlock * (row + 1), height_px_); ++v) {
        for (int u = kBlock * column; u < std::min(kBlock * (column + 1), width_px_); ++u) {
          same = same && pixels_[Index(u, v)].surface_key == key;
        }
      }
      block_keys_[BlockIndex(column, row)] = same ? key : kMixed;
    }
  }
  /// Whether a surface fills the picture at least `reach_px` round a pixel. True is certain; false
  /// may be said of a pixel not far from another surface.
  bool Alone(int u, int v, int reach_px) const {
    const int first_column = std::max(u - reach_px, 0) / kBlock;
    const int last_column = std::min(u + reach_px, width_px_ - 1) / kBlock;
    const int last_row = std::min(v + reach_px, height_px_ - 1) / kBlock;
    const std::uint32_t key = pixels_[Index(u, v)].surface_key;
    for (int row = std::max(v - reach_px, 0) / kBlock; row <= last_row; ++row) {
      for (int column = first_column; column <= last_column; ++column) {
        if (block_keys_[BlockIndex(column, row)] != key) return false;
      }
    }
    return true;
  }

  /// Light of a surface at a place between pixels' centres, from those of the four round it that
  /// show it. False: hardly any does.
  bool LightBetween(const Eigen::Vector2f& place_px, std::uint32_t surface_key,
                    Eigen::Array3f& light) const {
    const int u = FloorInt(place_px.x());
    const int v = FloorInt(place_px.y());
    const float fu = place_px.x() - static_cast<float>(u);
    const float fv = place_px.y() - static_cast<float>(v);
    Eigen::Array3f sum = Eigen::Array3f::Zero();
    float weights = 0.0F;
    for (int corner = 0; corner < 4; ++corner) {
      const int at_u = u + (corner & 1);
      const int at_v = v + (corner >> 1);
      if (KeyAt(at_u, at_v) != surface_key) continue;
      const float weight = ((corner & 1) != 0 ? fu : 1.0F - fu) * (corner > 1 ? fv : 1.0F - fv);
      sum += weight * LightAt(at_u, at_v);
      weights += weight;
    }
    if (weights < kLeastWeight) return false;
    light = sum / weights;
    return true;
  }

 private:
  static constexpr float kLeastWeight = 0.04F;
  static constexpr int kBlock = 4;
  static constexpr std::uint32_t kMixed = 4;  ///< no surface's either
  struct Pixel {
    float light[3] = {0.0F, 0.0F, 0.0F};
    std::uint32_t surface_key = kNothing;
  };
  bool Inside(int u, int v) const { return u >= 0 && v >= 0 && u < width_px_ && v < height_px_; }
  std::size_t Index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px_) +
           static_cast<std::size_t>(u);
  }

  std::size_t BlockIndex(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(blocks_across_) +
           static_cast<std::size_t>(column);
  }

  int width_px_, height_px_;
  std::vector<Pixel> pixels_;
  int blocks_across_;
  std::vector<std::uint32_t> block_keys_;  ///< the surface that fills a block, or kMixed
};

}  // namespace kawara::sim
