#include "vision/change/road_axis.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/geodesy.hpp"

namespace kawara::vision {
namespace {

constexpr double kSmooth = 3.0;  // m to either side

std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& line, double step) {
  std::vector<Eigen::Vector2d> even{line.front()};
  double since = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Eigen::Vector2d leg = line[i] - line[i - 1];
    const double length = leg.norm();
    double at = step - since;
    for (; at <= length; at += step) even.push_back(line[i - 1] + leg * (at / length));
    since = length - (at - step);
  }
  return even;
}

}  // namespace

Eigen::Vector2d RoadAxis::TangentAt(std::size_t i) const {
  const std::size_t before = i >= 2 ? i - 2 : 0, after = std::min(i + 2, points_m.size() - 1);
  const Eigen::Vector2d leg = points_m[after] - points_m[before];
  return leg.norm() > 0.0 ? Eigen::Vector2d(leg.normalized()) : Eigen::Vector2d(0.0, 1.0);
}

std::optional<RoadAxis> AxisAlong(const std::string& name,
                                  const std::vector<Eigen::Vector2d>& points_m) {
  std::vector<Eigen::Vector2d> line;
  for (const Eigen::Vector2d& p : points_m)
    if (line.empty() || (p - line.back()).norm() > 0.05) line.push_back(p);
  if (line.size() < 2) return std::nullopt;
  line = Resample(line, RoadAxis::kStep);
  if (line.size() < 2) return std::nullopt;
  // A mean over both sides of a point, as far as the nearer end allows: the ends stay.
  const auto reach = static_cast<std::ptrdiff_t>(kSmooth / RoadAxis::kStep);
  const auto count = static_cast<std::ptrdiff_t>(line.size());
  std::vector<Eigen::Vector2d> smooth;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t k = std::min({reach, i, count - 1 - i});
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::ptrdiff_t j = i - k; j <= i + k; ++j) sum += line[static_cast<std::size_t>(j)];
    smooth.emplace_back(sum / static_cast<double>(2 * k + 1));
  }
  return RoadAxis{name, Resample(smooth, RoadAxis::kStep)};
}

std::optional<double> RoadHeadingAt(const std::vector<RoadAxis>& axes, const Eigen::Vector2d& p) {
  constexpr double kFar = 50.0;
  double best = kFar;
  std::optional<double> heading;
  for (const RoadAxis& axis : axes) {
    for (std::size_t i = 0; i < axis.points_m.size(); ++i) {
      const double d = (axis.points_m[i] - p).norm();
      if (d >= best) continue;
      best = d;
      const Eigen::Vector2d tangent = axis.TangentAt(i);
      double angle = std::atan2(tangent.x(), tangent.y());
      if (angle < 0.0) angle += core::kPi;
      heading = std::fmod(angle, core::kPi);
    }
  }
  return heading;
}

}  // namespace kawara::vision
