#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "vision/model/texture.hpp"

namespace kawara::vision {

/// Where a quad's corners and middle lie, map frame [m], and its colour by the voxels.
struct QuadPlace {
  std::array<Eigen::Vector3d, 4> corners;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, outwards
  std::array<double, 3> colour{};
};
QuadPlace PlaceOf(const core::TexturedMesh& mesh, const Quad& quad);

/// The view that shows each quad best, and by how much each view's colours must be multiplied.
struct ViewChoice {
  static constexpr int kNone = -1;
  std::vector<int> view_of_quad;
  std::vector<std::array<double, 3>> gains;  ///< of each view, RGB
};
ViewChoice ChooseViews(const Surface& surface, double voxel_m, std::span<const TextureView> views,
                       const TextureConfig& config);

/// Pixel of a point of the map, if it lies within the picture.
std::optional<Eigen::Vector2d> PixelOf(const TextureView& view, const Eigen::Vector3d& point_m);

/// What a view's distance image says about a point of the map at `pixel`.
enum class Sight { kOpen, kHidden, kUnknown };
/// Hidden: something is nearer than `distance_m` by `margin_m` and three deviations of the range.
Sight SightOf(const TextureView& view, const Eigen::Vector2d& pixel, double distance_m,
              double margin_m);

/// Bilinear, RGB 0..255; at the border the nearest pixels.
std::array<double, 3> SampleAt(const ConstImageView& picture, const Eigen::Vector2d& pixel);

}  // namespace kawara::vision
