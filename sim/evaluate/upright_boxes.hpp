#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"

namespace kawara::sim {

/// A box on the ground as its eight apexes say, in a common plane east, north, up [m].
struct ApexBox {
  std::string id;
  std::string cls;
  /// Bottom four in order round the footprint, then the top four above them.
  std::array<Eigen::Vector3d, 8> apexes_enu_m;

  Eigen::Vector3d Centre() const;
  /// Length (the longer side), width, height.
  Eigen::Vector3d Size() const;
  /// Of the longer side, true, clockwise from north, in [0, pi): a box does not tell front from
  /// back.
  double Heading() const;
};

/// Shared volume over joint volume, 0..1, of two upright boxes with any headings.
double IntersectionOverUnion(const ApexBox& a, const ApexBox& b);

/// Reads boxes of a table (CSV, GeoPackage layer changed_object or object): columns id, class, and
/// for each apex i = 0..7 apex<i>_lon_deg, apex<i>_lat_deg, apex<i>_h_m. Where there is a column
/// t_end, rows that have ended are left out: they say what was there before. Errors: file, columns,
/// apexes that are no numbers.
core::Expected<std::vector<ApexBox>> ReadBoxes(const std::string& path,
                                               const core::LocalEnu& plane);
/// Where a table of boxes is: the place of its first apex, as origin of the plane to compare in.
core::Expected<core::Geodetic> PlaceOfBoxes(const std::string& path);

}  // namespace kawara::sim
