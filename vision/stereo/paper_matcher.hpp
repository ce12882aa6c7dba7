#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "vision/stereo/epipolar_curve.hpp"
#include "vision/stereo/paper_kernel.hpp"
#include "vision/stereo/range_image.hpp"
#include "vision/stereo/stereo_view.hpp"

namespace kawara::vision {

struct PaperMatcherOptions {
  double nearest_m = 1.5;  ///< nothing nearer is looked for
  int least_edge = 80;     ///< |gx| + |gy| of a colour edge, in one channel [levels]
};

/// Two pictures and their poses to the distance image of the first, by the method of the paper:
/// Meguro et al., section 4B. Colour edges (Sobel, each of red, green and blue) of both pictures
/// are the candidates. A candidate of A is looked for along its epipolar curve in B, eqs. (4) to
/// (8), at steps of a pixel of which one of the four pixels around is a candidate of B: a square
/// window, turned with the picture, the largest of the channels' differences, eqs. (9), (10), the
/// Gaussian-weighted sum of its squares, eq. (11), of that the minimum, eq. (12). All else here is
/// for time and changes no result.
///
/// What the paper leaves open: windows of 11 x 11 pixels, and where they are turned to: the
/// picture's direction of A's up axis, in B as in A, which in a ring is the azimuth, the paper's
/// own; with two cameras B's window is of A's angular size. The sub-pixel step is the vertex of the
/// parabola through the least sum and its neighbours on the curve, whether those are edges or not,
/// at most a step away. A minimum at an end of the curve is no minimum: unknown. A window that does
/// not lie within what the camera sees is no candidate.
///
/// The paper states no deviation; sd_m is ours: the noise of the step by the residuals at the
/// minimum and the curvature there, through the triangulation. It knows nothing of wrong minima.
///
/// Exposure must be the same in both pictures. Memory is kept from pair to pair; one thread at a
/// time.
class PaperMatcher {
 public:
  explicit PaperMatcher(const PaperMatcherOptions& options) : options_(options) {}

  /// `doubt` is in the deviations of all ranges. kInvalidArgument: no baseline.
  core::Expected<void> Match(const StereoView& a, const StereoView& b, RangeImage& ranges,
                             const StepDoubt& doubt = {});

  /// Of the last Match: what A's pixel is. Only edges with room are looked for.
  bool candidate(std::size_t pixel) const {
    return (a_.gate[pixel] & (kRoom | kEdge)) == (kRoom | kEdge);
  }

 private:
  static constexpr std::uint8_t kRoom = 1;  ///< a window there is within what the camera sees
  static constexpr std::uint8_t kEdge = 2;
  /// It, its right neighbour, or one of the two below is an edge.
  static constexpr std::uint8_t kNearEdge = 4;
  struct Prepared {
    std::vector<std::uint32_t> packed;
    std::vector<std::uint64_t> squares;
    std::vector<std::uint8_t> gate;
    paper::SquaredPicture picture;
    int width_px = 0, height_px = 0;
    /// Of the pixel up and left of a place; 0 outside the picture.
    std::uint8_t at(float u_px, float v_px) const {
      const int u = static_cast<int>(u_px), v = static_cast<int>(v_px);
      if (u < 0 || v < 0 || u >= width_px || v >= height_px) return 0;
      return gate[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px) +
                  static_cast<std::size_t>(u)];
    }
  };
  void Prepare(const StereoView& view, int margin_px, Prepared& out);
  void FindRoom(int margin_px, Prepared& out);
  void FindEdges(Prepared& out);
  struct Depth {
    float range_m, sd_m;
  };
  /// Of one candidate.
  Depth MatchPixel(const paper::WindowLevels& window, std::span<const CurveStep> steps,
                   double alpha_rad, const EpipolarPair& pair, const StepDoubt& doubt);

  PaperMatcherOptions options_;
  Prepared a_, b_;
  float across_a_ = 1.0F;  ///< -1: the picture is a mirror image
  float across_b_ = 1.0F;
  float pitch_b_ = 1.0F;
  std::vector<std::uint16_t> magnitude_, seen_rows_;
  std::vector<paper::WindowPlace> places_;
  std::vector<std::size_t> place_steps_;
  std::vector<std::int64_t> first_groups_;
};

}  // namespace kawara::vision
