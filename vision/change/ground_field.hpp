#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace kawara::vision {

struct GroundHeight {
  double up_m = 0.0;
  double sd_m = 0.0;
};

/// Heights of the ground in cells of a plane grid, as far as they are known. Cell (x, y) covers
/// [x, x + 1) * cell_m. Reading from any thread while nothing is written.
class GroundField {
 public:
  using Cell = std::pair<std::int32_t, std::int32_t>;

  explicit GroundField(double cell_m = 0.5) : cell_m_(cell_m) {}

  void Set(const Cell& cell, const GroundHeight& height) { cells_[KeyOf(cell)] = {cell, height}; }
  /// Between the centres of the known cells around, weighted bilinearly; nothing within two cells:
  /// nullopt.
  std::optional<GroundHeight> At(const Eigen::Vector2d& p) const;

  /// Null: not known.
  const GroundHeight* Find(const Cell& cell) const {
    const auto found = cells_.find(KeyOf(cell));
    return found == cells_.end() ? nullptr : &found->second.second;
  }

  double cell_m() const { return cell_m_; }
  bool empty() const { return cells_.empty(); }
  /// In order of their index.
  std::vector<std::pair<Cell, GroundHeight>> Cells() const;
  Cell CellOf(const Eigen::Vector2d& p) const;

 private:
  static std::int64_t KeyOf(const Cell& cell) {
    return cell.first * (std::int64_t{1} << 32) + cell.second;
  }

  double cell_m_;
  std::unordered_map<std::int64_t, std::pair<Cell, GroundHeight>> cells_;
};

}  // namespace kawara::vision
