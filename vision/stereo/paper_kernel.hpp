#pragma once
#include <cstddef>
#include <cstdint>

#include "vision/camera/radial_projection.hpp"

/// The inner loops of the paper's method, compiled for every SIMD target (Highway).
namespace kawara::vision::paper {

/// The window has 11 x 11 taps, a pixel apart; the deviation of its Gaussian weights k is in pixels
/// (the k of eq. (11); the paper gives no sizes, these are those its figures of accuracy are
/// reproduced with).
constexpr int kHalfWindow = 5;
constexpr double kWindowSd = 2.75;
/// The taps come in groups, those of a group spread over the window, so that the sum over the first
/// groups tells most wrong places. The last group is filled up with taps of weight zero.
constexpr std::size_t kTaps = 128;
constexpr std::size_t kGroup = 16;
/// A sum of eq. (11) in the unit of levels^2 counts this many; see Search().
constexpr double kCostUnit = 256.0;

/// Sum of the weights k.
double TotalWeight();
/// Sum of their squares.
double TotalSquaredWeight();

/// A picture for bilinear taps: two words a pixel, of which the first has the pixel's red, green,
/// blue and seen mark in its bytes 0, 2, 4, 6 and those of the pixel to the right in its bytes 1,
/// 3, 5, 7; the second the same of the row below. One load a tap: gathers are slow on many
/// processors.
struct SquaredPicture {
  const std::uint64_t* words = nullptr;
  int stride = 0;  ///< pixels from a row to the next; not a power of two, for the cache's sake
};
/// A row of it from one packed by MaskedRays::Pack and the one below it. The last pixel has a right
/// neighbour of zeros. words [2 * width].
void SquareRow(const std::uint32_t* row, const std::uint32_t* below, std::size_t width,
               std::uint64_t* words);

/// |gx| + |gy| by Sobel's masks in the channel where it is largest [levels]; columns 0 and width -
/// 1 are not written. Rows as of MaskedRays::Pack.
void SobelRow(const std::uint32_t* above, const std::uint32_t* row, const std::uint32_t* below,
              std::size_t width, std::uint16_t* magnitude);

/// Rays start * cosine[i] + turn * sine[i] of the OPTICAL frame, and where a camera sees them.
struct Arc {
  float start[3];
  float turn[3];
  float up[3];  ///< a fixed direction
};
/// NaN where the camera does not see a ray. All arrays [count rounded up to 16].
struct ArcPixels {
  float* u_px;
  float* v_px;
  float* up_u;  ///< where the pixel moves when its ray turns towards `up`; any length
  float* up_v;
};
void ProjectArc(const RadialTable& table, const Arc& arc, const float* cosine, const float* sine,
                std::size_t count, const ArcPixels& out);

/// A place for a window: its centre, the unit direction of its first axis, and of its second.
struct WindowPlace {
  float u_px, v_px;
  float along_u, along_v;
  float across_u, across_v;  ///< the pitch of the taps is in the length of both
};

/// A window's taps as Search() wants them.
struct alignas(64) WindowLevels {
  std::int16_t level[4 * kTaps];  ///< red, green, blue, the seen mark of each tap, times 128
};

/// Bilinear. That all taps lie within the picture is the caller's to see to, here and below.
void SampleWindow(const SquaredPicture& picture, const WindowPlace& place, WindowLevels& window);

/// The sum of eq. (11) at a place, in kCostUnit.
std::int64_t Cost(const WindowLevels& window, const SquaredPicture& picture,
                  const WindowPlace& place);

struct Found {
  std::size_t place = 0;
  std::int64_t cost = 0;
};
/// Eq. (12): the place of least cost, the first of several. Taps are left out only where the sum of
/// the others is too much already. count > 0; `first_groups` is for its own use, [count].
Found Search(const WindowLevels& window, const SquaredPicture& picture, const WindowPlace* places,
             std::size_t count, std::int64_t* first_groups);

}  // namespace kawara::vision::paper
