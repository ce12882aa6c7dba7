#pragma once
#include <array>
#include <cstdint>

#include "vision/image.hpp"

namespace kawara::vision {

/// The part of a picture that light is measured in: a ring (a mirror camera's; its corners are
/// always dark), or everything.
struct MeteringArea {
  double center_u_px = 0.0, center_v_px = 0.0;
  double inner_px = 0.0;
  double outer_px = 0.0;  ///< 0: the whole picture

  /// The same ring in a picture reduced by this factor.
  MeteringArea Scaled(double factor) const {
    return {center_u_px * factor, center_v_px * factor, inner_px * factor, outer_px * factor};
  }
};

/// How many of the looked-at pixels have each level 0..255 of luma (BT.601).
struct LightHistogram {
  std::array<std::uint32_t, 256> count{};
  std::uint32_t total = 0;

  void Add(std::uint8_t level) {
    ++count[level];
    ++total;
  }
  /// Mean of the light, 0..1, in which level v stands for (v / 255)^gamma, without the darkest and
  /// the brightest tenth: lamps, the sun and black holes do not move it. 0 if nothing was looked
  /// at.
  double TrimmedMean(double gamma) const;
  /// Share of pixels at 250 and above, 0..1.
  double SaturatedShare() const;
};

/// Looks at so many pixels, evenly spread, at most: enough for any mean and hardly any work.
constexpr int kMeteredPixels = 16384;

/// RGB8. Pure; any thread.
LightHistogram MeasureLight(const ConstImageView& picture, const MeteringArea& area);
/// Grey8, packed rows of `width_px` bytes.
LightHistogram MeasureGreyLight(const std::uint8_t* grey, int width_px, int height_px,
                                const MeteringArea& area);

}  // namespace kawara::vision
