#include "vision/sides/side_look.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "vision/model/view_choice.hpp"

namespace kawara::vision {
namespace {

constexpr double kMaxMarginM = 1.0;     // nobody is that wrong about a side's place
constexpr float kUnknownShare = 0.7F;   // of what no range tells about
constexpr float kBesideShare = 0.25F;   // of what is beside something hidden
constexpr int kFewHidden = 2;           // of nine: wrong ranges, not an edge
constexpr float kMaxJumpShare = 0.25F;  // of the picture, from node to node: its seam
constexpr float kNotInPicture = std::numeric_limits<float>::quiet_NaN();

class Looker {
 public:
  Looker(const SideGrid& grid, const SideView& view, const LookRules& rules)
      : grid_(grid), view_(view), rules_(rules) {}

  SideLook Look() {
    const Eigen::Vector3d camera_m = view_.view.map_from_camera.translation();
    SideLook look;
    height_m_ = grid_.normal.dot(camera_m - grid_.corner_m);
    if (!(height_m_ > 0.0)) return look;  // behind the side
    look.pixel.assign(grid_.nodes(), Eigen::Vector2f::Constant(kNotInPicture));
    look.quality.assign(grid_.nodes(), 0.0F);
    cosine_.assign(grid_.nodes(), 0.0F);
    sight_.assign(grid_.nodes(), Sight::kUnknown);
    Project(look);
    for (int j = 0; j < grid_.node_rows(); ++j)
      for (int i = 0; i < grid_.node_columns(); ++i) {
        const float quality = Quality(look, i, j);
        look.quality[grid_.node(i, j)] = quality;
        look.total += static_cast<double>(quality);
      }
    return look;
  }

 private:
  void Project(SideLook& look) {
    const Eigen::Matrix3d R_camera_map = view_.view.map_from_camera.linear().transpose();
    const Eigen::Vector3d right = R_camera_map * grid_.right_m, down = R_camera_map * grid_.down_m;
    const Eigen::Vector3d first =
        R_camera_map * (grid_.corner_m - view_.view.map_from_camera.translation());
    const int width = view_.view.picture.width_px, height = view_.view.picture.height_px;
    for (int j = 0; j < grid_.node_rows(); ++j)
      for (int i = 0; i < grid_.node_columns(); ++i) {
        const Eigen::Vector3d ray = first + i * right + j * down;
        const double distance_m = ray.norm(), cosine = height_m_ / distance_m;
        if (!(cosine > rules_.min_incidence_cos)) continue;
        const auto pixel = view_.view.camera.Project(ray);
        if (!pixel || !(pixel->x() >= -0.5 && pixel->y() >= -0.5 && pixel->x() < width - 0.5 &&
                        pixel->y() < height - 0.5))
          continue;
        const int u = std::clamp(static_cast<int>(std::lround(pixel->x())), 0, width - 1);
        const int v = std::clamp(static_cast<int>(std::lround(pixel->y())), 0, height - 1);
        if (!view_.mask.empty() &&
            view_.mask[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(u)] == 0)
          continue;
        const std::size_t n = grid_.node(i, j);
        look.pixel[n] = pixel->cast<float>();
        cosine_[n] = static_cast<float>(cosine);
        const double margin_m = std::min(rules_.depth_margin_m / cosine, kMaxMarginM);
        sight_[n] = SightOf(view_.view, *pixel, distance_m, margin_m);
      }
  }

  float Quality(const SideLook& look, int i, int j) const {
    int hidden = 0, open = 0;
    const int i0 = std::max(i - 1, 0), i1 = std::min(i + 1, grid_.cell_columns);
    const int j0 = std::max(j - 1, 0), j1 = std::min(j + 1, grid_.cell_rows);
    for (int y = j0; y <= j1; ++y)
      for (int x = i0; x <= i1; ++x) {
        const std::size_t n = grid_.node(x, y);
        if (std::isnan(look.pixel[n].x())) return 0.0F;
        hidden += sight_[n] == Sight::kHidden ? 1 : 0;
        open += sight_[n] == Sight::kOpen ? 1 : 0;
      }
    // Single ranges go wrong: the neighbours vote.
    if (hidden > open) return 0.0F;
    const std::size_t n = grid_.node(i, j);
    const auto at = [&](int x, int y) { return look.pixel[grid_.node(x, y)]; };
    const Eigen::Vector2f across = (at(i1, j) - at(i0, j)) / static_cast<float>(i1 - i0);
    const Eigen::Vector2f along = (at(i, j1) - at(i, j0)) / static_cast<float>(j1 - j0);
    const float jump = std::max(across.cwiseAbs().maxCoeff(), along.cwiseAbs().maxCoeff());
    if (jump > kMaxJumpShare * static_cast<float>(view_.view.picture.width_px)) return 0.0F;
    float quality = cosine_[n] * std::min(1.0F, LeastStretch(across, along) / SideGrid::kStep);
    if (hidden + open == 0) {
      quality *= kUnknownShare;
    } else if (hidden > kFewHidden) {
      quality *= kBesideShare;
    }
    return quality;
  }

  /// Smaller singular value of the matrix of two columns.
  static float LeastStretch(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    const float half = 0.5F * (a.squaredNorm() + b.squaredNorm());
    const float area = a.x() * b.y() - a.y() * b.x();
    return std::sqrt(std::max(0.0F, half - std::sqrt(std::max(0.0F, half * half - area * area))));
  }

  const SideGrid& grid_;
  const SideView& view_;
  const LookRules& rules_;
  double height_m_ = 0.0;  // of the camera over the side's plane
  std::vector<float> cosine_;
  std::vector<Sight> sight_;
};

}  // namespace

SideLook LookAtSide(const SideGrid& grid, const SideView& view, const LookRules& rules) {
  return Looker(grid, view, rules).Look();
}

}  // namespace kawara::vision
