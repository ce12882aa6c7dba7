#include "core/changed_object.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

namespace kawara::core {

Eigen::Vector2d UprightBox::Forward() const {
  return {std::sin(heading_rad), std::cos(heading_rad)};
}

Eigen::Vector2d UprightBox::Left() const { return {-std::cos(heading_rad), std::sin(heading_rad)}; }

std::array<Eigen::Vector3d, 8> UprightBox::Apexes() const {
  const Eigen::Vector2d along = Forward() * size_m.x() / 2, across = Left() * size_m.y() / 2;
  const std::array<Eigen::Vector2d, 4> corners{along + across, across - along, -along - across,
                                               along - across};
  std::array<Eigen::Vector3d, 8> apexes;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d at = centre_m.head<2>() + corners[i];
    apexes[i] = {at.x(), at.y(), centre_m.z() - size_m.z() / 2};
    apexes[i + 4] = {at.x(), at.y(), centre_m.z() + size_m.z() / 2};
  }
  return apexes;
}

// Clipping after Sutherland and Hodgman (CACM 1974): convex by convex.
double SharedFloor(const UprightBox& a, const UprightBox& b) {
  std::vector<Eigen::Vector2d> ring;
  const auto apexes = a.Apexes();
  for (std::size_t i = 0; i < 4; ++i) ring.emplace_back((apexes[i] - b.centre_m).head<2>());
  const auto clip = [&ring](const Eigen::Vector2d& outwards, double half_m) {
    std::vector<Eigen::Vector2d> kept;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d &p = ring[i], &q = ring[(i + 1) % ring.size()];
      const double before = p.dot(outwards) - half_m, after = q.dot(outwards) - half_m;
      if (before <= 0.0) kept.push_back(p);
      if ((before < 0.0 && after > 0.0) || (before > 0.0 && after < 0.0))
        kept.emplace_back(p + before / (before - after) * (q - p));
    }
    ring = std::move(kept);
  };
  clip(b.Forward(), b.size_m.x() / 2);
  clip(-b.Forward(), b.size_m.x() / 2);
  clip(b.Left(), b.size_m.y() / 2);
  clip(-b.Left(), b.size_m.y() / 2);
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d &p = ring[i], &q = ring[(i + 1) % ring.size()];
    twice += p.x() * q.y() - q.x() * p.y();
  }
  return std::abs(twice) / 2;
}

std::array<Eigen::Vector3d, 4> UprightBox::CornersOf(BoxSide side) const {
  constexpr std::array<std::array<std::size_t, 4>, kBoxSides> kApexes{
      {{7, 4, 0, 3}, {4, 5, 1, 0}, {5, 6, 2, 1}, {6, 7, 3, 2}, {4, 7, 6, 5}}};
  const auto apexes = Apexes();
  const auto& of_side = kApexes[static_cast<std::size_t>(side)];
  return {apexes[of_side[0]], apexes[of_side[1]], apexes[of_side[2]], apexes[of_side[3]]};
}

const char* ToString(BoxSide side) {
  switch (side) {
    case BoxSide::kFront:
      return "front";
    case BoxSide::kLeft:
      return "left";
    case BoxSide::kRear:
      return "rear";
    case BoxSide::kRight:
      return "right";
    case BoxSide::kTop:
      return "top";
  }
  return "unknown";
}

const char* ToString(ChangeState state) {
  switch (state) {
    case ChangeState::kNew:
      return "new";
    case ChangeState::kConfirmed:
      return "confirmed";
    case ChangeState::kMoved:
      return "moved";
    case ChangeState::kGrown:
      return "grown";
    case ChangeState::kGone:
      return "gone";
  }
  return "unknown";
}

const char* ToString(SizeClass cls) {
  switch (cls) {
    case SizeClass::kUnknown:
      return "unknown";
    case SizeClass::kTruck:
      return "truck";
    case SizeClass::kCar:
      return "car";
    case SizeClass::kRubble:
      return "rubble";
    case SizeClass::kPerson:
      return "person";
  }
  return "unknown";
}

}  // namespace kawara::core
