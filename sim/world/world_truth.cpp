#include "sim/world/world_truth.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <iterator>
#include <memory>

#include "core/config/config.hpp"
#include "sim/site/reference_model.hpp"
#include "sim/site/truth_geopackage.hpp"
#include "sim/site/truth_objects.hpp"
#include "sim/vehicle/drive_truth_csv.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kPosePeriod = core::Milliseconds(10);

/// A text file written line by line; errors are noticed at the end.
class TextFile {
 public:
  explicit TextFile(std::filesystem::path path)
      : path_(std::move(path)), file_(std::fopen(path_.c_str(), "w"), std::fclose) {}
  std::FILE* get() const { return file_.get(); }
  core::Expected<void> Close() {
    const bool whole = file_ && std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
    if (whole) return {};
    return tl::unexpected(core::ErrnoError("write " + path_.string(), errno));
  }

 private:
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

double Degrees0To360(double angle_rad) {
  const double deg = angle_rad * core::kDegFromRad;
  return deg < 0.0 ? deg + 360.0 : deg;
}

core::Expected<void> WriteCameraPoses(const SiteWorld& world, const std::filesystem::path& path) {
  TextFile file(path);
  if (file.get() == nullptr) return file.Close();
  std::fputs("gps_ns,lat_deg,lon_deg,h_ellipsoidal_m,roll_deg,pitch_deg,yaw_deg\n", file.get());
  const Trajectory& motion = world.trajectory();
  for (core::GpsTime t = motion.begin(); t <= motion.end(); t += kPosePeriod) {
    const core::Geodetic place = motion.GeodeticAt(t, world.robot().vehicle.camera_frd_m);
    const core::Attitude attitude = motion.AttitudeAt(t);
    std::fprintf(file.get(), "%lld,%.11f,%.11f,%.5f,%.6f,%.6f,%.6f\n",
                 static_cast<long long>(t.ns()), place.lat_rad * core::kDegFromRad,
                 place.lon_rad * core::kDegFromRad, place.h_ellipsoidal_m,
                 attitude.roll_rad * core::kDegFromRad, attitude.pitch_rad * core::kDegFromRad,
                 Degrees0To360(attitude.yaw_rad));
  }
  return file.Close();
}

core::Expected<void> WriteText(const std::filesystem::path& path, const std::string& text) {
  TextFile file(path);
  if (file.get() != nullptr) std::fputs(text.c_str(), file.get());
  return file.Close();
}

}  // namespace

core::Expected<void> WriteWorldTruth(const SiteWorld& world, const std::filesystem::path& folder) {
  auto done = WriteDriveTruth(world.truth(), folder);
  if (done) done = WriteCameraPoses(world, folder / "truth_camera.csv");
  if (done) done = WriteObjectsCsv(world.scene(), folder / "truth_objects.csv");
  if (done) {
    Scene news;
    news.origin = world.scene().origin;
    std::copy_if(world.scene().objects.begin(), world.scene().objects.end(),
                 std::back_inserter(news.objects),
                 [](const SceneObject& object) { return !object.in_reference; });
    done = WriteObjectsCsv(news, folder / "truth_new_objects.csv");
  }
  if (done) {
    done =
        WriteTruthGeoPackage(world.scene(), world.site(), world.terrain(), folder / "truth.gpkg");
  }
  const auto& site = world.site();
  const auto& terrain = world.terrain();
  if (done) done = WriteReferenceCityJson(site, terrain, folder / "reference_city.json");
  if (done) done = WriteRoadGeoJson(site, terrain, folder / "reference_road.geojson");
  if (done) done = WriteGroundGrid(site, terrain, folder / "reference_ground.asc");
  if (done) done = WriteText(folder / "site.yaml", core::config::Dump(world.site()));
  if (done) done = WriteText(folder / "robot.yaml", core::config::Dump(world.robot()));
  return done;
}

}  // namespace kawara::sim
