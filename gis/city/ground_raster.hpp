#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/frame/map_frame.hpp"

namespace kawara::gis {

struct GroundOptions {
  int band = 1;
  /// Only this far around the map's origin is read [m].
  double radius_m = 5000.0;
};

/// Heights of the ground from a raster (GeoTIFF, or whatever else GDAL knows) in the map's east,
/// north, up [m]. Immutable; any thread.
class GroundRaster {
 public:
  /// kFromFile: the raster's reference system; kLocalMetres: its geotransform leads to east and
  /// north, and its heights are up, as they are. Errors, with the way to mend them: kNotFound;
  /// kFormat; kInvalidArgument: no such band, no reference system, no geotransform, or nothing of
  /// it within the radius.
  static core::Expected<GroundRaster> Read(const std::string& path, const MapFrame& frame,
                                           const GroundOptions& options = {});

  /// Between the middles of the four cells around it, bilinear; over cells without data by those
  /// that have some, if they weigh half or more. Half a cell beyond the last middles the last cell
  /// holds. nullopt: nobody knows.
  std::optional<double> HeightAt(double east_m, double north_m) const;

  double cell_m() const { return cell_m_; }  ///< the longer side, at the origin
  HeightDatum heights() const { return heights_; }
  std::size_t known_cells() const { return known_cells_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }

 private:
  /// From east and north to the raster, near a place; what a height becomes there.
  struct Patch {
    Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
    Eigen::Vector2d cell = Eigen::Vector2d::Zero();  ///< column, row of middle_m
    Eigen::Matrix2d cell_from_m = Eigen::Matrix2d::Zero();
    double lift_m = 0.0;  ///< up minus height
    Eigen::Vector2d lift_slope = Eigen::Vector2d::Zero();
  };
  class Builder;
  GroundRaster() = default;
  const Patch* PatchAt(double east_m, double north_m) const;
  double Cell(int column, int row) const {
    return static_cast<double>(
        heights_m_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(column)]);
  }

  int columns_ = 0, rows_ = 0;
  std::vector<float> heights_m_;  ///< minus base_m_; NaN: no data
  double base_m_ = 0.0;
  double cell_m_ = 0.0;
  HeightDatum heights_ = HeightDatum::kUnknown;
  std::size_t known_cells_ = 0;
  std::vector<Patch> patches_;  ///< one for local metres, else a grid of patch_m_
  Eigen::Vector2d patches_low_m_ = Eigen::Vector2d::Zero();
  double patch_m_ = 0.0;
  int patch_columns_ = 0, patch_rows_ = 0;
};

}  // namespace kawara::gis
