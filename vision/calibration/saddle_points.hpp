#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

namespace kawara::vision {

/// A grey picture of floats, rows from the top, levels 0..255.
struct GreyPicture {
  std::vector<float> level;
  int width_px = 0;
  int height_px = 0;

  float at(int u, int v) const {
    return level[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px) +
                 static_cast<std::size_t>(u)];
  }
  /// Between pixels, linear; beyond the edge the edge's level.
  float Sample(double u, double v) const;
};

/// A place where the brightness rises both ways along one line and falls both ways across it, as
/// where four squares of a chessboard meet.
struct SaddlePoint {
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();
  double strength = 0.0;           ///< root of -det of the Hessian [levels / px^2]
  Eigen::Vector2d bright;          ///< unit: towards the two bright squares
  Eigen::Vector2d edge_a, edge_b;  ///< unit: along the two edges that cross here
};

/// All saddle points of a picture smoothed by a Gaussian of `blur_px`, strongest first, at most
/// `limit`. Any thread.
std::vector<SaddlePoint> FindSaddlePoints(const GreyPicture& picture, double blur_px, int limit);

/// The crossing of the edges near `start_px` to some hundredths of a pixel: the point whose lines
/// to the pixels around it, within about `window_px`, are square to the gradients there. `gradient`
/// of GradientOf(). Source: Foerstner and Guelch, "A fast operator for detection and precise
/// location of distinct points, corners and centres of circular features", 1987. Empty: it runs
/// away from `start_px`, or over the picture's edge.
struct Gradient {
  GreyPicture u, v;
};
Gradient GradientOf(const GreyPicture& picture);
std::optional<Eigen::Vector2d> RefineCrossing(const Gradient& gradient,
                                              const Eigen::Vector2d& start_px, double window_px);

}  // namespace kawara::vision
