#include <GeographicLib/UTMUPS.hpp>
#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "gis/model/model_writers.hpp"
#include "gis/model/text.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {
namespace {

static_assert(std::endian::native == std::endian::little);

// ASPRS LAS 1.4 R15: table 3 (public header), 12 (point format 7), 2.5 (variable length records).
constexpr std::uint16_t kHeaderBytes = 375;
constexpr std::uint16_t kRecordHeaderBytes = 54;
constexpr std::uint8_t kPointFormat = 7;
constexpr std::uint16_t kPointBytes = 36;
constexpr std::uint16_t kWktRecord = 2112;
constexpr std::uint16_t kCoordinatesAreWkt = 1U << 4U;
constexpr double kScaleM = 0.001;

void AppendPadded(std::string& bytes, std::string_view text, std::size_t size) {
  const std::string_view cut = text.substr(0, size);
  bytes += cut;
  bytes.append(size - cut.size(), '\0');
}

// EPSG:32600 / 32700 + zone.
std::string UtmWkt(int zone, bool is_north) {
  const std::string name = "WGS 84 / UTM zone " + std::to_string(zone) + (is_north ? "N" : "S");
  return "PROJCS[\"" + name +
         "\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563,"
         "AUTHORITY[\"EPSG\",\"7030\"]],AUTHORITY[\"EPSG\",\"6326\"]],PRIMEM[\"Greenwich\",0,"
         "AUTHORITY[\"EPSG\",\"8901\"]],UNIT[\"degree\",0.0174532925199433,"
         "AUTHORITY[\"EPSG\",\"9122\"]],AUTHORITY[\"EPSG\",\"4326\"]],"
         "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
         "PARAMETER[\"central_meridian\"," +
         std::to_string(6 * zone - 183) +
         "],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],"
         "PARAMETER[\"false_northing\"," +
         (is_north ? "0" : "10000000") +
         "],UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]],AXIS[\"Easting\",EAST],"
         "AXIS[\"Northing\",NORTH],AUTHORITY[\"EPSG\",\"" +
         std::to_string((is_north ? 32600 : 32700) + zone) + "\"]]";
}

struct Cloud {
  int zone = 0;
  bool is_north = true;
  std::vector<Eigen::Vector3d> utm_m;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero(), low_m, high_m;
};

core::Expected<Cloud> ToUtm(std::span<const core::ColouredPoint> points,
                            const core::Geodetic& origin) {
  Cloud cloud;
  const core::LocalEnu enu(origin);
  double gamma = 0.0, scale = 0.0;
  const auto forward = [&](const core::Geodetic& g, int set_zone) {
    Eigen::Vector3d p(0, 0, g.h_ellipsoidal_m);
    bool is_north = true;
    GeographicLib::UTMUPS::Forward(g.lat_rad * core::kDegFromRad, g.lon_rad * core::kDegFromRad,
                                   cloud.zone, is_north, p.x(), p.y(), gamma, scale, set_zone);
    // One false northing for all, also across the equator.
    if (set_zone == GeographicLib::UTMUPS::STANDARD) cloud.is_north = is_north;
    if (is_north != cloud.is_north) p.y() += cloud.is_north ? -1e7 : 1e7;
    return p;
  };
  const Eigen::Vector3d first = forward(origin, GeographicLib::UTMUPS::STANDARD);
  if (cloud.zone == GeographicLib::UTMUPS::UPS)
    return core::Fail(core::ErrorCode::kInvalidArgument, "LAS: no UTM zone at the poles");
  const int zone = cloud.zone;
  cloud.offset_m = first.array().floor();
  cloud.low_m = cloud.high_m = cloud.offset_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].position_m.allFinite() || points[i].position_m.norm() > 1e5)
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "LAS: a point more than 100 km from the origin");
    Eigen::Vector3d p = forward(enu.ToGeodetic(points[i].position_m), zone);
    // As the file will say it.
    p = cloud.offset_m + ((p - cloud.offset_m) / kScaleM).array().round().matrix() * kScaleM;
    cloud.low_m = i == 0 ? p : Eigen::Vector3d(cloud.low_m.cwiseMin(p));
    cloud.high_m = i == 0 ? p : Eigen::Vector3d(cloud.high_m.cwiseMax(p));
    cloud.utm_m.push_back(p);
  }
  return cloud;
}

std::string Header(const Cloud& cloud, std::size_t wkt_bytes) {
  const std::uint64_t n = cloud.utm_m.size();
  std::string h = "LASF";
  AppendBytes(h, std::uint16_t{0});  // source
  AppendBytes(h, kCoordinatesAreWkt);
  h.append(16, '\0');  // project GUID
  h += '\1';
  h += '\4';
  AppendPadded(h, "Kawaraban voxel centroids", 32);
  AppendPadded(h, "Kawaraban", 32);
  AppendBytes(h, std::uint16_t{1});  // day and year of making: a fixed one, files are reproducible
  AppendBytes(h, std::uint16_t{2000});
  AppendBytes(h, kHeaderBytes);
  AppendBytes(h, static_cast<std::uint32_t>(kHeaderBytes + kRecordHeaderBytes + wkt_bytes));
  AppendBytes(h, std::uint32_t{1});  // variable length records
  AppendBytes(h, kPointFormat);
  AppendBytes(h, kPointBytes);
  h.append(4 + 5 * 4, '\0');  // legacy counts: none for formats above 5
  for (int i = 0; i < 3; ++i) AppendBytes(h, kScaleM);
  for (const double v : cloud.offset_m) AppendBytes(h, v);
  for (Eigen::Index i = 0; i < 3; ++i) {
    AppendBytes(h, cloud.high_m[i]);
    AppendBytes(h, cloud.low_m[i]);
  }
  h.append(8 + 8 + 4, '\0');  // waveforms, extended records
  AppendBytes(h, n);
  AppendBytes(h, n);  // all of them first returns
  h.append(std::size_t{14} * 8, '\0');
  return h;
}

}  // namespace

core::Expected<void> WriteLas(const std::filesystem::path& path,
                              std::span<const core::ColouredPoint> points,
                              const core::Geodetic& origin) {
  const auto cloud = ToUtm(points, origin);
  if (!cloud) return tl::unexpected(cloud.error());
  const std::string wkt = UtmWkt(cloud->zone, cloud->is_north) + '\0';
  std::string file = Header(*cloud, wkt.size());
  AppendBytes(file, std::uint16_t{0});
  AppendPadded(file, "LASF_Projection", 16);
  AppendBytes(file, kWktRecord);
  AppendBytes(file, static_cast<std::uint16_t>(wkt.size()));
  AppendPadded(file, "heights: WGS 84 ellipsoid", 32);
  file += wkt;
  file.reserve(file.size() + points.size() * kPointBytes);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k)
      AppendBytes(file, static_cast<std::int32_t>(
                            std::lround((cloud->utm_m[i][k] - cloud->offset_m[k]) / kScaleM)));
    AppendBytes(file, points[i].votes);
    AppendBytes(file, std::uint8_t{0x11});  // return 1 of 1
    AppendBytes(file, std::uint8_t{0});
    AppendBytes(file, std::uint8_t{1});  // class: unassigned
    AppendBytes(file, std::uint8_t{0});
    AppendBytes(file, std::int16_t{0});
    AppendBytes(file, std::uint16_t{0});
    AppendBytes(file, 0.0);  // GPS time: of many pictures
    for (const std::uint8_t c : points[i].colour)
      AppendBytes(file, static_cast<std::uint16_t>(c * 257));
  }
  return WriteWholeFile(path, file);
}

}  // namespace kawara::gis
