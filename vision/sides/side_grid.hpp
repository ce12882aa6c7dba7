#pragma once
#include <Eigen/Core>
#include <cstddef>

#include "core/changed_object.hpp"

namespace kawara::vision {

/// A side of a box cut into texels, map frame [m]. Every kStep texels there is a NODE, the first
/// ones on the upper and left edges, the last ones on the lower and right: what a picture is good
/// for is decided at nodes, and between them interpolated. A CELL lies between four nodes.
struct SideGrid {
  static constexpr int kStep = 4;

  Eigen::Vector3d corner_m = Eigen::Vector3d::Zero();  ///< upper left, seen from outside
  Eigen::Vector3d right_m = Eigen::Vector3d::Zero();   ///< from node to node
  Eigen::Vector3d down_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, outwards
  int cell_columns = 0, cell_rows = 0;

  int width_px() const { return kStep * cell_columns; }
  int height_px() const { return kStep * cell_rows; }
  int node_columns() const { return cell_columns + 1; }
  int node_rows() const { return cell_rows + 1; }
  std::size_t nodes() const {
    return static_cast<std::size_t>(node_columns()) * static_cast<std::size_t>(node_rows());
  }
  std::size_t cells() const {
    return static_cast<std::size_t>(cell_columns) * static_cast<std::size_t>(cell_rows);
  }
  std::size_t node(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(node_columns()) +
           static_cast<std::size_t>(i);
  }
  std::size_t cell(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(cell_columns) +
           static_cast<std::size_t>(i);
  }
};

/// Texels of at most `texel_m`, whole cells of them.
SideGrid GridOf(const core::UprightBox& box, core::BoxSide side, double texel_m);

/// Standard deviation of where the side is, along its normal [m]: of the box's place, size and,
/// on the mean over the side, heading.
double SideDeviation(const core::ChangedObject& object, core::BoxSide side);

}  // namespace kawara::vision
