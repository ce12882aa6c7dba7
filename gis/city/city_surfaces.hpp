#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "gis/frame/crs_to_enu.hpp"
#include "gis/frame/map_frame.hpp"

/// Objects of city models as plain surfaces in the map: what readers of CityGML and CityJSON give.
namespace kawara::gis {

/// Rings are not closed; east, north, up [m].
struct CitySurface {
  std::vector<Eigen::Vector3d> outer_m;
  std::vector<std::vector<Eigen::Vector3d>> holes_m;
};

struct CityObject {
  std::string name;  ///< or its id in the file
  int lod = 0;       ///< level of detail of the surfaces, whole part
  std::vector<CitySurface> surfaces;
  std::optional<core::UtcTime> date;  ///< of the survey, else of the object's making
  std::optional<double> sigma_m;      ///< if the file states one
};

struct CityObjects {
  std::vector<CityObject> objects;
  HeightDatum heights = HeightDatum::kUnknown;
  std::size_t passed_over = 0;  ///< objects without surfaces of a fitting level, odd surfaces
};

/// Takes the coordinates of a city model to the map, in the order the model has them: the
/// authority's, if the reference system is named by URN or URL (GML 3.2, CityJSON), else easting
/// first. Many writers get it wrong; so if the first point comes to lie beyond kFar_m of the map's
/// origin and would not with the axes exchanged, exchanged they are. One thread only.
class CityAxes {
 public:
  /// kInvalidArgument: no reference system though one is wanted, or one nobody knows.
  static core::Expected<CityAxes> Make(const std::string& reference_system, const MapFrame& frame);
  static constexpr double kFar_m = 200e3;

  Eigen::Vector3d Place(const Eigen::Vector3d& p);
  HeightDatum heights() const { return crs_ ? crs_->heights() : HeightDatum::kUnknown; }

 private:
  CityAxes() = default;
  std::optional<CrsToEnu> crs_;
  bool northing_first_ = false;
  bool is_judged_ = false;
};

/// "2020", "2020-03", "2020-03-31" or a whole time stamp; a part that is missing is its first.
std::optional<core::UtcTime> DateOf(const std::string& text);

}  // namespace kawara::gis
