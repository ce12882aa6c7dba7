#pragma once
#include <cstddef>
#include <cstdint>

/// The inner loops of the semi-global search, compiled for every SIMD target (Highway). All arrays
/// of disparities are padded to a multiple of kLane.
namespace kawara::vision::semi_global {

constexpr std::size_t kLane = 16;
/// Differences of contrast beyond this say no more than "different".
constexpr std::uint8_t kCap = 90;
/// Cost of comparing with what the other camera does not see.
constexpr std::uint8_t kUnseen = 60;
/// Half height and half width of the window over which differences are summed.
constexpr int kWindow = 2;
/// Added to a path's cost for a change of disparity by one, and by more.
constexpr std::uint16_t kStepCost = 12;
constexpr std::uint16_t kJumpCost = 80;

/// A window has structure when the mean of its costs is this much above that at its best disparity;
/// it repeats itself when another disparity comes within this part of the difference.
constexpr int kStructure = 25;
constexpr int kRepeatPart = 16;
/// Nearer than this to the best is still the best: a slanted window fits a little everywhere.
constexpr std::uint16_t kBesides = 3;

/// Space before and behind the disparities of a path, so that neighbours can be read at the ends.
constexpr std::size_t kPathPad = 16;
constexpr std::size_t PathStride(std::size_t disparities) { return disparities + 2 * kPathPad; }

/// differences[x][d] = |a[x] - b[x + d]|, capped; b and b_seen are readable to width + disparities.
void Differences(const std::uint8_t* a, const std::uint8_t* a_seen, const std::uint8_t* b,
                 const std::uint8_t* b_seen, std::size_t width, std::size_t disparities,
                 std::uint8_t* differences);

/// sum[i] += added[i] - removed[i].
void SlideRows(const std::uint8_t* added, const std::uint8_t* removed, std::size_t count,
               std::uint16_t* sum);

/// cost[x][d] = sum over the window's columns of sum[x + k][d], / 16. The ends repeat.
void WindowCosts(const std::uint16_t* sum, std::size_t width, std::size_t disparities,
                 std::uint8_t* cost);

/// One row of costs of one path direction, [width][PathStride], and each pixel's least.
struct PathRow {
  std::uint16_t* cost;
  std::uint16_t* least;
};

/// Paths from above (left above, above, right above) and from the left, then from the right; their
/// sum into total[x][d]. `previous` are the three rows of above, all zeros before the first row.
void PathsDown(const std::uint8_t* cost, const std::uint8_t* seen, std::size_t width,
               std::size_t disparities, const PathRow previous[3], const PathRow current[3],
               const PathRow& along, std::uint16_t* total);

/// Paths from below; added to total.
void PathsUp(const std::uint8_t* cost, const std::uint8_t* seen, std::size_t width,
             std::size_t disparities, const PathRow previous[3], const PathRow current[3],
             std::uint16_t* total);

/// What is least: for each pixel of A, and for each pixel of B on the same meridian.
struct RowMinima {
  std::uint16_t* best;         ///< [width] disparity
  std::uint16_t* best_cost;    ///< [width]
  std::uint16_t* second_cost;  ///< [width] least of those not beside the best
  std::uint16_t* b_best;       ///< [width + disparities]
  std::uint16_t* b_cost;       ///< [width + disparities]
};
void FindMinima(const std::uint16_t* total, const std::uint8_t* seen, std::size_t width,
                std::size_t disparities, const RowMinima& minima);

/// Whether a pixel's own window fits elsewhere as well as at its best disparity although it has
/// structure enough to tell: a fence, a row of windows. repeats[x] is 1 or 0.
void FindRepeats(const std::uint8_t* cost, const std::uint16_t* best, std::size_t width,
                 std::size_t disparities, std::uint8_t* repeats);

}  // namespace kawara::vision::semi_global
