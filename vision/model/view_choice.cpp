#include "vision/model/view_choice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

constexpr double kNeighbourBonus = 1.3;  // a seam must be worth it
constexpr double kUnknownShare = 0.5;    // of a view whose distance image is silent there
constexpr double kSigmas = 3.0;
/// Of ranges that come without deviations, in parts of them.
constexpr double kUnstatedSd = 0.02;

// How well a view shows a quad; 0: not at all.
double Score(const TextureView& view, const QuadPlace& quad, double voxel_m, double least_cos,
             const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d to_camera = view.map_from_camera.translation() - quad.middle;
  const double distance_m = to_camera.norm();
  const double cosine = quad.normal.dot(to_camera) / distance_m;
  if (!(cosine > least_cos)) return 0.0;
  double score = cosine / (distance_m * distance_m);
  const Sight sight = SightOf(view, pixel, distance_m, 1.5 * voxel_m);
  if (sight == Sight::kHidden) return 0.0;
  if (sight == Sight::kUnknown && view.ranges != nullptr) score *= kUnknownShare;
  return score;
}

}  // namespace

QuadPlace PlaceOf(const core::TexturedMesh& mesh, const Quad& quad) {
  QuadPlace place;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& p = mesh.positions_m[quad[i]];
    place.corners[i] = mesh.offset_m + Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
    place.middle += 0.25 * place.corners[i];
    for (std::size_t c = 0; c < 3; ++c) place.colour[c] += 0.25 * mesh.colours[quad[i]][c];
  }
  const Eigen::Vector3d twice_area =
      (place.corners[2] - place.corners[0]).cross(place.corners[3] - place.corners[1]);
  const double length = twice_area.norm();
  if (length > 0.0) place.normal = twice_area / length;
  return place;
}

std::optional<Eigen::Vector2d> PixelOf(const TextureView& view, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d ray = view.map_from_camera.inverse() * point_m;
  if (!(ray.squaredNorm() > 1e-12)) return std::nullopt;
  auto pixel = view.camera.Project(ray);
  if (!pixel ||
      !(pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() <= view.picture.width_px - 1.0 &&
        pixel->y() <= view.picture.height_px - 1.0))
    return std::nullopt;
  return pixel;
}

Sight SightOf(const TextureView& view, const Eigen::Vector2d& pixel, double distance_m,
              double margin_m) {
  if (view.ranges == nullptr) return Sight::kUnknown;
  const RangeImage& ranges = *view.ranges;
  const int step = ranges.width_px < view.picture.width_px ? 2 : 1;
  const auto place = [step](double at, int size) {
    return std::clamp(static_cast<int>(std::lround(at)) / step, 0, size - 1);
  };
  const std::size_t i =
      ranges.index(place(pixel.x(), ranges.width_px), place(pixel.y(), ranges.height_px));
  const auto range_m = static_cast<double>(ranges.range_m[i]);
  if (std::isnan(range_m)) return Sight::kUnknown;
  const double sd_m =
      ranges.sd_m.empty() ? kUnstatedSd * distance_m : static_cast<double>(ranges.sd_m[i]);
  return range_m < distance_m - kSigmas * sd_m - margin_m ? Sight::kHidden : Sight::kOpen;
}

std::array<double, 3> SampleAt(const ConstImageView& picture, const Eigen::Vector2d& pixel) {
  const double u = std::clamp(pixel.x(), 0.0, picture.width_px - 1.0);
  const double v = std::clamp(pixel.y(), 0.0, picture.height_px - 1.0);
  const int u0 = std::min(static_cast<int>(u), std::max(picture.width_px - 2, 0));
  const int v0 = std::min(static_cast<int>(v), std::max(picture.height_px - 2, 0));
  const int u1 = std::min(u0 + 1, picture.width_px - 1),
            v1 = std::min(v0 + 1, picture.height_px - 1);
  const double right = u - u0, down = v - v0;
  const auto at = [&](int column, int row, std::size_t c) {
    return static_cast<double>(picture.row(row)[static_cast<std::size_t>(column) * kRgbBytes + c]);
  };
  std::array<double, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = (1 - down) * ((1 - right) * at(u0, v0, c) + right * at(u1, v0, c)) +
             down * ((1 - right) * at(u0, v1, c) + right * at(u1, v1, c));
  return rgb;
}

ViewChoice ChooseViews(const Surface& surface, double voxel_m, std::span<const TextureView> views,
                       const TextureConfig& config) {
  ViewChoice choice;
  choice.view_of_quad.assign(surface.quads.size(), ViewChoice::kNone);
  std::vector<std::array<double, 3>> ours(views.size()), theirs(views.size());
  int last = ViewChoice::kNone;
  for (std::size_t q = 0; q < surface.quads.size(); ++q) {
    const QuadPlace quad = PlaceOf(surface.mesh, surface.quads[q]);
    double best = 0.0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto pixel = PixelOf(views[v], quad.middle);
      if (!pixel) continue;
      double score = Score(views[v], quad, voxel_m, config.min_incidence_cos, *pixel);
      if (!(score > 0.0)) continue;
      const auto seen = SampleAt(views[v].picture, *pixel);
      for (std::size_t c = 0; c < 3; ++c) {
        ours[v][c] += quad.colour[c];
        theirs[v][c] += seen[c];
      }
      if (static_cast<int>(v) == last) score *= kNeighbourBonus;
      const bool whole =
          score > best && std::all_of(quad.corners.begin(), quad.corners.end(), [&](const auto& p) {
            return PixelOf(views[v], p).has_value();
          });
      if (!whole) continue;
      best = score;
      choice.view_of_quad[q] = static_cast<int>(v);
    }
    last = choice.view_of_quad[q];
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto& gain = choice.gains.emplace_back(std::array{1.0, 1.0, 1.0});
    for (std::size_t c = 0; c < 3; ++c)
      if (theirs[v][c] > 0.0 && ours[v][c] > 0.0)
        gain[c] = std::clamp(ours[v][c] / theirs[v][c], 0.5, 2.0);
  }
  return choice;
}

}  // namespace kawara::vision
