#include "vision/refine/patch_align.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace kawara::vision {
namespace {

/// Place across and along, stretch and shear of the rows, gain, offset.
using Vector6f = Eigen::Matrix<float, 6, 1>;
using Matrix6f = Eigen::Matrix<float, 6, 6>;

/// How steep surfaces are believed to be: stretch and shear, 1 sigma.
constexpr float kSlopeSd = 0.25F;
/// Of the brightness of a pixel [8-bit levels].
constexpr float kLevelSd = 3.0F;
/// The window's Gaussian, in parts of its half.
constexpr float kWindowSd = 0.6F;

bool Holds(const LevelsView& picture, const Eigen::Vector2f& at, float margin) {
  return at.x() >= margin && at.y() >= margin &&
         at.x() < static_cast<float>(picture.width_px) - margin &&
         at.y() < static_cast<float>(picture.height_px) - margin;
}

/// Value and gradient of the bilinear surface.
Eigen::Vector3f Sample(const LevelsView& picture, float x, float y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float u = x - static_cast<float>(column), v = y - static_cast<float>(row);
  const float* top = picture.row(row) + column;
  const float* bottom = picture.row(row + 1) + column;
  const float left = top[0] + v * (bottom[0] - top[0]);
  const float right = top[1] + v * (bottom[1] - top[1]);
  const float up = top[0] + u * (top[1] - top[0]);
  const float down = bottom[0] + u * (bottom[1] - bottom[0]);
  return {left + u * (right - left), right - left, down - up};
}

/// What a picture shows about a place: where from there, the level, and how much it counts.
struct PatchPixel {
  float x = 0.0F, y = 0.0F, level = 0.0F, weight = 0.0F;
};

std::vector<PatchPixel> PatchOf(const LevelsView& picture, const Eigen::Vector2f& at, int half_px) {
  const auto half = static_cast<float>(half_px);
  const float sharpness = -0.5F / (half * half * kWindowSd * kWindowSd);
  const std::size_t side = 2 * static_cast<std::size_t>(half_px) + 1;
  std::vector<PatchPixel> patch;
  patch.reserve(side * side);
  for (int v = -half_px; v <= half_px; ++v) {
    for (int u = -half_px; u <= half_px; ++u) {
      const auto x = static_cast<float>(u), y = static_cast<float>(v);
      patch.push_back({x, y, Sample(picture, at.x() + x, at.y() + y)(0),
                       std::exp(sharpness * (x * x + y * y))});
    }
  }
  return patch;
}

}  // namespace

std::optional<Eigen::Vector2f> AlignPatch(const LevelsView& a, const LevelsView& b,
                                          const Eigen::Vector2f& at_a, const Eigen::Vector2f& guess,
                                          const PatchAlignOptions& options) {
  const auto half = static_cast<float>(options.half_px);
  // Stretched by half its size it must still be inside.
  const float margin = 1.5F * half + 2.0F;
  if (!Holds(a, at_a, half + 2.0F)) return std::nullopt;
  const std::vector<PatchPixel> patch = PatchOf(a, at_a, options.half_px);
  Vector6f state = Vector6f::Zero();
  state(4) = 1.0F;
  Vector6f believed = Vector6f::Zero();
  believed(2) = believed(3) = kLevelSd * kLevelSd / (kSlopeSd * kSlopeSd);
  for (int step = 0; step < options.most_steps; ++step) {
    const Eigen::Vector2f here = guess + state.head<2>();
    if (!Holds(b, here, margin) || std::abs(state(2)) > 0.5F || std::abs(state(3)) > 0.5F) {
      return std::nullopt;
    }
    Matrix6f normal = believed.asDiagonal();
    Vector6f gradient = believed.cwiseProduct(state);
    for (const PatchPixel& pixel : patch) {
      const Eigen::Vector3f seen = Sample(
          b, here.x() + (1.0F + state(2)) * pixel.x + state(3) * pixel.y, here.y() + pixel.y);
      Vector6f by;
      by << seen(1), seen(2), seen(1) * pixel.x, seen(1) * pixel.y, -pixel.level, -1.0F;
      const float residual = seen(0) - state(4) * pixel.level - state(5);
      normal.noalias() += pixel.weight * by * by.transpose();
      gradient += pixel.weight * residual * by;
    }
    const Vector6f move = -normal.ldlt().solve(gradient);
    if (!move.allFinite()) return std::nullopt;
    state += move;
    if (state.head<2>().norm() > options.farthest_px) return std::nullopt;
    if (move.head<2>().norm() < options.still_px) return guess + state.head<2>();
  }
  return std::nullopt;
}

}  // namespace kawara::vision
