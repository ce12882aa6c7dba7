#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "gis/frame/map_frame.hpp"

class OGRSpatialReference;

namespace kawara::gis {

/// Takes coordinates of a reference system (projected, geographic, with or without a height system)
/// to the map's east, north, up. x is the easting or longitude, y the northing or latitude,
/// whatever order the authority prefers; z the height, in the height system's unit; without one, in
/// the unit of x and y if they are lengths (so US states write their LAS), else in metres.
///
/// The plane goes to WGS 84 by PROJ, as exactly as it can without grids; a height is only scaled to
/// metres and lifted by geoid_separation_m (see MapFrame): no geoid model is consulted.
/// One thread only. PROJ: https://proj.org, ISO 19111.
class CrsToEnu {
 public:
  /// `crs`: WKT of any generation, "EPSG:6677", "urn:ogc:def:crs:EPSG::6697",
  /// "https://www.opengis.net/def/crs/EPSG/0/4979". kInvalidArgument: nobody knows it, or it is
  /// not of this kind (earth-centred, engineering); names it.
  static core::Expected<CrsToEnu> Make(const std::string& crs, const MapFrame& frame);
  /// With the order of axes that the reference's own mapping states (as an OGR layer's does).
  static core::Expected<CrsToEnu> Make(const OGRSpatialReference& crs, const MapFrame& frame);

  CrsToEnu(CrsToEnu&&) noexcept;
  CrsToEnu& operator=(CrsToEnu&&) noexcept;
  ~CrsToEnu();

  const std::string& name() const;  ///< "WGS 84 / UTM zone 54N"
  HeightDatum heights() const;
  /// The authority puts latitude (northing) first: so do GML and CityJSON files that name it.
  bool IsNorthingFirst() const;

  /// One point, by the full formula. NaN where the system is not defined.
  Eigen::Vector3d Exact(const Eigen::Vector3d& p);
  /// Many points, in place: by a plane fitted to each patch of 64 m, checked at the patch's corners
  /// to be right to kFitTolerance_m (where it is not, by the full formula). The same result
  /// whatever the order or grouping of the points. NaN as above.
  void Convert(std::span<Eigen::Vector3d> points);
  static constexpr double kFitTolerance_m = 0.0005;

  /// Back: x, y of a point of the map [m]. NaN where the system is not defined.
  Eigen::Vector2d Back(const Eigen::Vector3d& enu_m);
  /// Metres a unit of the file's heights.
  double metres_per_height() const;
  /// Up in the map, at a place of it, of a height [m] above the file's zero: what a raster needs.
  double UpOf(const Eigen::Vector2d& enu_m, double height_m) const;

 private:
  struct State;
  explicit CrsToEnu(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Registers GDAL's drivers once; anybody, any thread.
void RegisterGdal();

}  // namespace kawara::gis
