#pragma once
#include <cstddef>
#include <cstdint>

/// The inner loops of sub-pixel refinement, compiled for every SIMD target (Highway).
namespace kawara::vision::refine {

/// Half width of the Gaussian window, and the window's deviation [px].
constexpr int kRadius = 5;
constexpr float kWindowSd = 2.75F;
/// A neighbour belongs to the same surface when its disparity differs by less than
/// kEdge * (1 + kEdgeGrowth * distance) [px].
constexpr float kEdge = 1.0F;
constexpr float kEdgeGrowth = 0.15F;
/// Largest step of an iteration [px].
constexpr float kLargestStep = 1.0F;
/// Mean square slope, three channels together, below which nothing is learned [levels^2 / px^2].
constexpr float kPlain = 0.5F;
/// Squared slopes, three channels together, that noise alone makes for a mean squared residual of
/// one: 1.3 on average (measured on pictures of nothing but noise, rectified as any), 2 where a
/// window has drawn much of it, and such windows must not pass for texture. And the least part of
/// the squared slopes that is taken for the scene's.
constexpr float kNoiseSlopes = 2.0F;
constexpr float kLeastScene = 0.1F;
/// Variance of a window's mean over that of a pixel: the sum of the squares of its weights, and a
/// little for what neighbouring pixels share by interpolation.
constexpr float kWindowVariance = 0.0105F * 1.25F;
/// What no averaging takes away, summed over the channels [levels^2]: patterns of the sensor and of
/// the compression, shading that the gains do not follow.
constexpr float kPattern = 0.08F;
/// The least an 8-bit picture's residual can be, mean of a channel [levels^2].
constexpr float kLeastResidual = 0.25F;
/// What remains in the best textured places: interpolation, the picture's own sampling [px].
constexpr float kFloorSd = 0.03F;
/// How well the rows of both pictures are the same meridians [px]: what an edge that runs along
/// them makes of it is an error of the disparity.
constexpr float kRowSd = 0.1F;
/// In the arrays here: no disparity. Far enough from every disparity to be on no surface.
constexpr float kNone = -1e4F;
/// Rows have this many elements before the first and behind the last, with kNone as disparity.
constexpr std::size_t kPad = 32;

/// What a row of pixels says of its disparities, all rows [width].
struct Evidence {
  float* slope_error;   ///< w * sum of slope * error over the channels
  float* slope_square;  ///< w * sum of slope^2
  float* error_square;  ///< mean of error^2 over the channels
  float* slope_cross;   ///< w * sum of slope * the slope across the rows
};

/// A's level over B's, of kGainColumns columns beside each other: base + rise * column.
constexpr std::size_t kGainColumns = 32;
struct GainLine {
  float base = 1.0F;
  float rise = 0.0F;
};

struct ResidualRow {
  const std::uint32_t* a;      ///< packed, rectified_picture.hpp
  const std::uint32_t* above;  ///< A's rows beside it
  const std::uint32_t* below;
  const std::uint32_t* b;
  const float* disparity;   ///< of A's pixels
  const GainLine* gain[3];  ///< of a channel, [columns / kGainColumns + 1]
  std::size_t width;
  float softness;  ///< w = 1 / (1 + softness * error_square)
};
/// error = A(x) - gain B(x + disparity), slope = its derivative by the disparity; zeros where
/// either picture is not seen.
void Residuals(const ResidualRow& row, const Evidence& evidence);

/// Mean over the neighbours on the same surface, along the row. in and out of `disparity` and the
/// evidence; out.disparity is kNone where in's is.
struct SmoothRow {
  float* disparity;
  Evidence evidence;
  float* support;  ///< weights of the neighbours that were on the surface, over those of the window
};
void SmoothAlong(const SmoothRow& in, std::size_t width, const SmoothRow& out);
/// The same across rows: rows[kRadius] is the one to smooth, null where the picture ends.
void SmoothAcross(const SmoothRow* const rows[2 * kRadius + 1], std::size_t width,
                  const SmoothRow& out);

/// The next disparities: the smoothed ones and the step that the evidence asks for.
void Advance(const SmoothRow& smoothed, std::size_t width, float* disparity);
/// Their standard deviations [px] by the smoothed evidence. `width` is a multiple of 16.
void Deviations(const SmoothRow& smoothed, std::size_t width, float* sd);

}  // namespace kawara::vision::refine
