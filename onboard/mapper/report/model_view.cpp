#include "onboard/mapper/report/model_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "core/geodesy.hpp"
#include "onboard/mapper/report/evenly_spread.hpp"

namespace kawara::mapper {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr double kElevationRad = 35.0 * core::kRadFromDeg;
/// Pictures become no taller than so many times their width.
constexpr double kMostTall = 1.0;
constexpr std::size_t kPointsForBox = 100'000;

/// Rows: the picture's right, its down, and away from who looks; in east, north, up.
Eigen::Matrix3d Axes(ViewFrom from) {
  Eigen::Vector3d away(0.0, 0.0, -1.0), right(1.0, 0.0, 0.0);
  if (from != ViewFrom::kAbove) {
    // Seen from the south-east one looks north-west.
    const double north_west = from == ViewFrom::kSouthEast ? 1.0 : -1.0;
    const Eigen::Vector3d level = north_west * Eigen::Vector3d(-1.0, 1.0, 0.0).normalized();
    away = std::cos(kElevationRad) * level - std::sin(kElevationRad) * Eigen::Vector3d::UnitZ();
    right = level.cross(Eigen::Vector3d::UnitZ());
  }
  Eigen::Matrix3d axes;
  axes.row(0) = right;
  axes.row(1) = away.cross(right);
  axes.row(2) = away;
  return axes;
}

std::string Caption(ViewFrom from) {
  switch (from) {
    case ViewFrom::kAbove:
      return "From above; north is up";
    case ViewFrom::kSouthEast:
      return "From the south-east, 35\u00B0 above the horizon";
    case ViewFrom::kNorthWest:
      return "From the north-west, 35\u00B0 above the horizon";
  }
  return "";
}

}  // namespace

MapBox BoxOf(std::span<const core::ColouredPoint> points) {
  MapBox box;
  std::vector<double> along;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    along.clear();
    for (const auto& point : points) {
      if (point.position_m.allFinite()) along.push_back(point.position_m[axis]);
    }
    if (along.empty()) return {};
    const std::size_t cut = along.size() / 1000;
    const auto at = [&along](std::size_t i) {
      const auto place = along.begin() + static_cast<std::ptrdiff_t>(i);
      std::nth_element(along.begin(), place, along.end());
      return *place;
    };
    box.min_m[axis] = at(cut);
    box.max_m[axis] = at(along.size() - 1 - cut);
  }
  return box;
}

ModelView::ModelView(ViewFrom from, const MapBox& box, double point_m, int width_px)
    : from_(from), point_m_(point_m), view_from_map_(Axes(from)) {
  constexpr double kHuge = std::numeric_limits<double>::infinity();
  Eigen::Vector3d low = Eigen::Vector3d::Constant(kHuge), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d m((corner & 1) != 0 ? box.max_m.x() : box.min_m.x(),
                            (corner & 2) != 0 ? box.max_m.y() : box.min_m.y(),
                            (corner & 4) != 0 ? box.max_m.z() : box.min_m.z());
    const Eigen::Vector3d seen = view_from_map_ * m;
    low = low.cwiseMin(seen);
    high = high.cwiseMax(seen);
  }
  low.array() -= point_m_;
  high.array() += point_m_;
  const Eigen::Vector3d size = (high - low).cwiseMax(1e-3);
  px_per_m_ = std::min(width_px / size.x(), kMostTall * width_px / size.y());
  width_px_ = std::max(1, static_cast<int>(std::ceil(size.x() * px_per_m_ - 1e-6)));
  height_px_ = std::max(1, static_cast<int>(std::ceil(size.y() * px_per_m_ - 1e-6)));
  // A cell's diagonal, so that neighbours on a grid leave no gaps when it is seen askew.
  point_px_ = static_cast<int>(std::ceil(std::numbers::sqrt2 * point_m_ * px_per_m_));
  corner_m_ = low;
  const auto pixels = static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  depth_m_.assign(pixels, kNothing);
  rgb_.assign(vision::kRgbBytes * pixels, 0);
}

void ModelView::Add(std::span<const core::ColouredPoint> points) {
  for (const auto& point : points) Draw(point);
}

void ModelView::Draw(const core::ColouredPoint& point) {
  const Eigen::Vector3d seen = view_from_map_ * point.position_m - corner_m_;
  const Eigen::Vector2d middle_px = seen.head<2>() * px_per_m_;
  // Compared before they become integers, which NaN and far points would not fit.
  if (!(middle_px.x() > -point_px_ && middle_px.x() < width_px_ + point_px_ &&
        middle_px.y() > -point_px_ && middle_px.y() < height_px_ + point_px_)) {
    return;
  }
  const auto depth = static_cast<float>(seen.z());
  const int left = static_cast<int>(std::lround(middle_px.x() - 0.5 * point_px_));
  const int top = static_cast<int>(std::lround(middle_px.y() - 0.5 * point_px_));
  for (int v = std::max(top, 0); v < std::min(top + point_px_, height_px_); ++v) {
    for (int u = std::max(left, 0); u < std::min(left + point_px_, width_px_); ++u) {
      const std::size_t i = index(u, v);
      if (!(depth < depth_m_[i])) continue;
      depth_m_[i] = depth;
      std::copy(point.colour.begin(), point.colour.end(),
                rgb_.begin() + static_cast<std::ptrdiff_t>(vision::kRgbBytes * i));
    }
  }
}

double ModelView::ShadeAt(int u, int v) const {
  // How much nearer the neighbours are, on the scale of a point; steps of a point or two are what a
  // slanting plane of squares has of itself.
  const auto depth = static_cast<double>(depth_m_[index(u, v)]);
  const int reach = point_px_;
  double nearer = 0.0;
  const auto add = [&](int uu, int vv) {
    if (uu < 0 || vv < 0 || uu >= width_px_ || vv >= height_px_) return;
    const auto there = static_cast<double>(depth_m_[index(uu, vv)]);
    if (std::isfinite(there)) nearer += std::clamp((depth - there) / point_m_ - 2.0, 0.0, 6.0);
  };
  add(u - reach, v);
  add(u + reach, v);
  add(u, v - reach);
  add(u, v + reach);
  return std::exp(-0.05 * nearer);
}

ReportPicture ModelView::Picture() const {
  constexpr std::uint8_t kBackground = 245;
  std::vector<std::uint8_t> shaded(rgb_.size(), kBackground);
  int left = width_px_, top = height_px_, right = 0, bottom = 0;  // of what is to be seen
  for (int v = 0; v < height_px_; ++v) {
    for (int u = 0; u < width_px_; ++u) {
      const std::size_t i = index(u, v);
      if (!std::isfinite(depth_m_[i])) continue;
      left = std::min(left, u);
      right = std::max(right, u + 1);
      top = std::min(top, v);
      bottom = std::max(bottom, v + 1);
      const double shade = ShadeAt(u, v);
      for (std::size_t k = vision::kRgbBytes * i; k < vision::kRgbBytes * (i + 1); ++k) {
        shaded[k] = static_cast<std::uint8_t>(std::lround(shade * rgb_[k]));
      }
    }
  }
  if (left >= right) return {};
  // A box seen askew leaves the corners empty.
  std::vector<std::uint8_t> cut;
  for (int v = top; v < bottom; ++v) {
    const auto at = [&](int u) {
      return shaded.begin() + static_cast<std::ptrdiff_t>(vision::kRgbBytes * index(u, v));
    };
    cut.insert(cut.end(), at(left), at(right - 1) + vision::kRgbBytes);
  }
  ReportPicture picture =
      PhotoForReport({cut.data(), right - left, bottom - top}, Caption(from_), width_px_);
  picture.px_per_m = px_per_m_;
  return picture;
}

core::Expected<std::vector<ReportPicture>> DrawModelViews(const PointParts& parts, double point_m) {
  // A box that leaves out a thousandth does not need them all.
  EvenlySpread<core::ColouredPoint> sample(kPointsForBox);
  const auto gathered = parts([&sample](std::span<const core::ColouredPoint> points) {
    for (const auto& point : points) sample.Offer([&point] { return point; });
  });
  if (!gathered) return tl::unexpected(gathered.error());
  std::vector<ReportPicture> pictures;
  if (sample.kept().empty()) return pictures;
  const MapBox box = BoxOf(sample.kept());
  std::vector<ModelView> views;
  for (const ViewFrom from : {ViewFrom::kAbove, ViewFrom::kSouthEast, ViewFrom::kNorthWest}) {
    views.emplace_back(from, box, point_m);
  }
  const auto drawn = parts([&views](std::span<const core::ColouredPoint> points) {
    for (ModelView& view : views) view.Add(points);
  });
  if (!drawn) return tl::unexpected(drawn.error());
  for (const ModelView& view : views) {
    ReportPicture picture = view.Picture();
    if (!picture.bytes.empty()) pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace kawara::mapper
