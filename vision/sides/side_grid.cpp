#include "vision/sides/side_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kawara::vision {

SideGrid GridOf(const core::UprightBox& box, core::BoxSide side, double texel_m) {
  const auto corners = box.CornersOf(side);
  const Eigen::Vector3d right = corners[1] - corners[0], down = corners[3] - corners[0];
  const auto cells = [&](double length_m) {
    return std::max(1, static_cast<int>(std::ceil(length_m / (SideGrid::kStep * texel_m) - 1e-9)));
  };
  SideGrid grid;
  grid.cell_columns = cells(right.norm());
  grid.cell_rows = cells(down.norm());
  grid.corner_m = corners[0];
  grid.right_m = right / grid.cell_columns;
  grid.down_m = down / grid.cell_rows;
  grid.normal = down.cross(right).normalized();
  return grid;
}

double SideDeviation(const core::ChangedObject& object, core::BoxSide side) {
  constexpr int kHeading = 6;
  const auto corners = object.box.CornersOf(side);
  const Eigen::Vector3d right = corners[1] - corners[0], down = corners[3] - corners[0];
  const int size_row = side == core::BoxSide::kTop                                     ? 5
                       : side == core::BoxSide::kFront || side == core::BoxSide::kRear ? 3
                                                                                       : 4;
  Eigen::Matrix<double, core::ChangedObject::kParameters, 1> change;
  change.setZero();
  change.head<3>() = down.cross(right).normalized();
  change(size_row) = 0.5;
  double variance = change.dot(object.covariance * change);
  // A turn moves a place by its distance from the middle; its square's mean is width^2 / 12.
  if (side != core::BoxSide::kTop)
    variance += object.covariance(kHeading, kHeading) * right.squaredNorm() / 12.0;
  return std::sqrt(std::max(variance, 0.0));
}

}  // namespace kawara::vision
