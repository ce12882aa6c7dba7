#include "gis/frame/crs_to_enu.hpp"

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <limits>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gis/gdal_errors.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPatch_m = 64.0;
constexpr double kMetresPerDegree = 111'320.0;
constexpr double kProbeHeight_m = 1000.0;
constexpr std::size_t kMostPatches = 100'000;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct DestroyTransformation {
  void operator()(OGRCoordinateTransformation* t) const {
    OGRCoordinateTransformation::DestroyCT(t);
  }
};
using Transformation = std::unique_ptr<OGRCoordinateTransformation, DestroyTransformation>;

/// East, north, up around a patch's middle: exactly linear in height (a point moves along the
/// ellipsoid's normal), nearly so in x and y.
struct Patch {
  Vector2d middle = Vector2d::Zero();
  Vector3d at_zero = Vector3d::Zero(), by_x = Vector3d::Zero(), by_y = Vector3d::Zero();
  Vector3d normal = Vector3d::Zero(), normal_by_x = Vector3d::Zero(),
           normal_by_y = Vector3d::Zero();
  bool good = false;

  Vector3d At(double x, double y, double h_m) const {
    const double dx = x - middle.x(), dy = y - middle.y();
    return at_zero + by_x * dx + by_y * dy + h_m * (normal + normal_by_x * dx + normal_by_y * dy);
  }
};

struct PatchKey {
  std::int64_t x = 0, y = 0;
  bool operator==(const PatchKey&) const = default;
};
struct PatchHash {
  std::size_t operator()(const PatchKey& key) const {
    return std::hash<std::uint64_t>()(static_cast<std::uint64_t>(key.x) * 0x9E3779B97F4A7C15ULL ^
                                      static_cast<std::uint64_t>(key.y));
  }
};

core::Error Refusal(const std::string& name, const std::string& why) {
  return {core::ErrorCode::kInvalidArgument, "reference system " + name + ": " + why};
}

std::string NameOf(const OGRSpatialReference& crs) {
  const char* name = crs.GetName();
  return name == nullptr ? "without a name" : name;
}

}  // namespace

void RegisterGdal() {
  static std::once_flag once;
  std::call_once(once, [] { GDALAllRegister(); });
}

struct CrsToEnu::State {
  explicit State(const MapFrame& frame)
      : enu(frame.origin), separation_m(frame.geoid_separation_m) {}

  std::string name;
  HeightDatum heights = HeightDatum::kUnknown;
  bool northing_first = false;
  core::LocalEnu enu;
  double separation_m;
  double metres_per_height = 1.0;
  double patch_size = kPatch_m;  ///< in units of x and y
  Transformation to_wgs84, from_wgs84;
  std::unordered_map<PatchKey, Patch, PatchHash> patches;
  PatchKey last_key;
  const Patch* last = nullptr;

  double Lifted(double height_m) const {
    return height_m + (heights == HeightDatum::kEllipsoidal ? 0.0 : separation_m);
  }
  double Metres(double height) const { return Lifted(height * metres_per_height); }

  Vector3d Exact(double x, double y, double h_m) const {
    int good = 0;
    if (!std::isfinite(x) || !std::isfinite(y) ||
        !to_wgs84->Transform(1, &x, &y, nullptr, nullptr, &good) || good == 0 ||
        !std::isfinite(x) || !std::isfinite(y) || std::abs(y) > 90.0)
      return Vector3d::Constant(kNan);
    return enu.FromGeodetic({y * core::kRadFromDeg, x * core::kRadFromDeg, h_m});
  }

  Patch Fit(const PatchKey& key) const {
    Patch p;
    const double half = patch_size / 2.0;
    p.middle = {(static_cast<double>(key.x) + 0.5) * patch_size,
                (static_cast<double>(key.y) + 0.5) * patch_size};
    const auto corner = [&](double sx, double sy, double h_m) {
      return Exact(p.middle.x() + sx * half, p.middle.y() + sy * half, h_m);
    };
    const auto normal = [&](double sx, double sy) -> Vector3d {
      return (corner(sx, sy, kProbeHeight_m) - corner(sx, sy, 0.0)) / kProbeHeight_m;
    };
    p.at_zero = corner(0, 0, 0.0);
    p.by_x = (corner(1, 0, 0.0) - corner(-1, 0, 0.0)) / patch_size;
    p.by_y = (corner(0, 1, 0.0) - corner(0, -1, 0.0)) / patch_size;
    p.normal = normal(0, 0);
    p.normal_by_x = (normal(1, 0) - normal(-1, 0)) / patch_size;
    p.normal_by_y = (normal(0, 1) - normal(0, -1)) / patch_size;
    p.good = true;
    for (const double sx : {-1.0, 1.0})
      for (const double sy : {-1.0, 1.0})
        for (const double h_m : {0.0, kProbeHeight_m}) {
          const Vector3d fitted = p.At(p.middle.x() + sx * half, p.middle.y() + sy * half, h_m);
          // Written so that NaN is no good either.
          if (!((fitted - corner(sx, sy, h_m)).norm() <= kFitTolerance_m)) p.good = false;
        }
    return p;
  }

  const Patch& PatchAt(double x, double y) {
    const PatchKey key{static_cast<std::int64_t>(std::floor(x / patch_size)),
                       static_cast<std::int64_t>(std::floor(y / patch_size))};
    if (last != nullptr && key == last_key) return *last;
    if (patches.size() > kMostPatches) patches.clear();
    auto found = patches.find(key);
    if (found == patches.end()) found = patches.emplace(key, Fit(key)).first;
    last_key = key;
    last = &found->second;
    return *last;
  }
};

CrsToEnu::CrsToEnu(std::unique_ptr<State> state) : state_(std::move(state)) {}
CrsToEnu::CrsToEnu(CrsToEnu&&) noexcept = default;
CrsToEnu& CrsToEnu::operator=(CrsToEnu&&) noexcept = default;
CrsToEnu::~CrsToEnu() = default;

const std::string& CrsToEnu::name() const { return state_->name; }
HeightDatum CrsToEnu::heights() const { return state_->heights; }
bool CrsToEnu::IsNorthingFirst() const { return state_->northing_first; }

core::Expected<CrsToEnu> CrsToEnu::Make(const std::string& crs, const MapFrame& frame) {
  const GdalErrorCatcher errors;
  OGRSpatialReference reference;
  // A name in a file must not make us open another file or the network.
  if (reference.SetFromUserInput(
          crs.c_str(), OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS) != OGRERR_NONE) {
    return tl::unexpected(Refusal(
        "\"" + crs.substr(0, 80) + "\"",
        "not known (expected: WKT or a code such as EPSG:6677; does the file have local metres?)"));
  }
  reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return Make(reference, frame);
}

core::Expected<CrsToEnu> CrsToEnu::Make(const OGRSpatialReference& crs, const MapFrame& frame) {
  const GdalErrorCatcher errors;
  auto state = std::make_unique<State>(frame);
  state->name = NameOf(crs);
  if (crs.IsGeocentric())
    return tl::unexpected(
        Refusal(state->name, "earth-centred coordinates are not read (convert them to EPSG:4979)"));
  if (!crs.IsGeographic() && !crs.IsProjected())
    return tl::unexpected(
        Refusal(state->name, "neither geographic nor projected (are these local metres?)"));

  OGRSpatialReference plane(crs);
  std::vector<int> axes = crs.GetDataAxisToSRSAxisMapping();
  if (crs.IsCompound()) {
    const char* vertical = crs.GetAttrValue("VERT_CS");
    const std::string vertical_name = vertical == nullptr ? "" : vertical;
    state->heights = vertical_name.find("llipsoid") == std::string::npos
                         ? HeightDatum::kSeaLevel
                         : HeightDatum::kEllipsoidal;
    state->metres_per_height = crs.GetTargetLinearUnits("VERT_CS");
    plane.StripVertical();
  } else {
    if (crs.GetAxesCount() == 3) state->heights = HeightDatum::kEllipsoidal;
    if (crs.IsProjected()) state->metres_per_height = crs.GetLinearUnits();
  }
  if (plane.GetAxesCount() == 3) plane.DemoteTo2D(nullptr);
  if (axes.size() > 2) axes.resize(2);
  plane.SetDataAxisToSRSAxisMapping(axes);
  state->northing_first = plane.EPSGTreatsAsLatLong() || plane.EPSGTreatsAsNorthingEasting();
  state->patch_size =
      plane.IsGeographic() ? kPatch_m / kMetresPerDegree : kPatch_m / plane.GetLinearUnits();

  OGRSpatialReference wgs84;
  wgs84.SetWellKnownGeogCS("WGS84");
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  state->to_wgs84.reset(OGRCreateCoordinateTransformation(&plane, &wgs84));
  state->from_wgs84.reset(OGRCreateCoordinateTransformation(&wgs84, &plane));
  if (!state->to_wgs84 || !state->from_wgs84)
    return tl::unexpected(Refusal(state->name, "no way from it to WGS 84: " + errors.message()));
  return CrsToEnu(std::move(state));
}

Vector3d CrsToEnu::Exact(const Vector3d& p) {
  const GdalErrorCatcher errors;
  return state_->Exact(p.x(), p.y(), state_->Metres(p.z()));
}

void CrsToEnu::Convert(std::span<Vector3d> points) {
  const GdalErrorCatcher errors;
  // What no system's coordinates reach must not become the number of a patch.
  constexpr double kMost = 1e9;
  for (Vector3d& p : points) {
    if (!(std::abs(p.x()) < kMost && std::abs(p.y()) < kMost)) {
      p.setConstant(kNan);
      continue;
    }
    const double h_m = state_->Metres(p.z());
    const Patch& patch = state_->PatchAt(p.x(), p.y());
    p = patch.good ? patch.At(p.x(), p.y(), h_m) : state_->Exact(p.x(), p.y(), h_m);
  }
}

Vector2d CrsToEnu::Back(const Vector3d& enu_m) {
  const GdalErrorCatcher errors;
  if (!enu_m.allFinite()) return Vector2d::Constant(kNan);
  const core::Geodetic g = state_->enu.ToGeodetic(enu_m);
  double x = g.lon_rad * core::kDegFromRad, y = g.lat_rad * core::kDegFromRad;
  int good = 0;
  if (!state_->from_wgs84->Transform(1, &x, &y, nullptr, nullptr, &good) || good == 0)
    return Vector2d::Constant(kNan);
  return {x, y};
}

double CrsToEnu::metres_per_height() const { return state_->metres_per_height; }

double CrsToEnu::UpOf(const Vector2d& enu_m, double height_m) const {
  const double h_m = state_->Lifted(height_m);
  // Up at this place with which the height above the ellipsoid becomes h_m; the ellipsoid falls
  // away from the plane by a metre in 3.6 km, so that twice is to the micrometre.
  double up_m = h_m - state_->enu.origin().h_ellipsoidal_m;
  for (int i = 0; i < 2; ++i)
    up_m += h_m - state_->enu.ToGeodetic({enu_m.x(), enu_m.y(), up_m}).h_ellipsoidal_m;
  return up_m;
}

}  // namespace kawara::gis
