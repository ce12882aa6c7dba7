#pragma once
#include <cstddef>
#include <cstdint>

#include "vision/stereo/squared_picture.hpp"

/// The windows of the paper's method and their sums, compiled for every SIMD target (Highway).
namespace kawara::vision::paper {

/// The window has 11 x 11 taps, a pixel apart; its Gaussian weights, the k of eq. (11), have this
/// deviation in pixels. The paper gives neither size.
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
