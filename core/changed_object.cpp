#include "core/changed_object.hpp"

#include <cmath>

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
