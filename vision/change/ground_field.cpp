#include "vision/change/ground_field.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {

GroundField::Cell GroundField::CellOf(const Eigen::Vector2d& p) const {
  return {static_cast<std::int32_t>(std::floor(p.x() / cell_m_)),
          static_cast<std::int32_t>(std::floor(p.y() / cell_m_))};
}

std::vector<std::pair<GroundField::Cell, GroundHeight>> GroundField::Cells() const {
  std::vector<std::pair<Cell, GroundHeight>> all;
  all.reserve(cells_.size());
  for (const auto& [key, cell] : cells_) all.push_back(cell);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return all;
}

std::optional<GroundHeight> GroundField::At(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d grid = p / cell_m_ - Eigen::Vector2d::Constant(0.5);
  const Eigen::Vector2d base(std::floor(grid.x()), std::floor(grid.y()));
  const Eigen::Vector2d part = grid - base;
  const auto bx = static_cast<std::int32_t>(base.x()), by = static_cast<std::int32_t>(base.y());
  double sum = 0.0, height = 0.0, sd = 0.0;
  const auto add = [&](std::int32_t x, std::int32_t y, double weight) {
    const auto found = cells_.find(KeyOf({x, y}));
    if (found == cells_.end() || weight <= 0.0) return;
    sum += weight;
    height += weight * found->second.second.up_m;
    sd += weight * found->second.second.sd_m;
  };
  for (std::int32_t dy = 0; dy <= 1; ++dy)
    for (std::int32_t dx = 0; dx <= 1; ++dx)
      add(bx + dx, by + dy,
          (dx == 1 ? part.x() : 1 - part.x()) * (dy == 1 ? part.y() : 1 - part.y()));
  if (sum < 0.1) {  // nearly nothing right here: what there is around, by its distance
    sum = height = sd = 0.0;
    for (std::int32_t dy = -1; dy <= 2; ++dy)
      for (std::int32_t dx = -1; dx <= 2; ++dx)
        add(bx + dx, by + dy, 1.0 / (0.1 + (part - Eigen::Vector2d(dx, dy)).squaredNorm()));
  }
  if (sum <= 0.0) return std::nullopt;
  return GroundHeight{height / sum, sd / sum};
}

}  // namespace kawara::vision
