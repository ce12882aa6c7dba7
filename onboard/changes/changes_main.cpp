// kawara-changes: what stands on the road that the reference does not know.
#include <CLI/CLI.hpp>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <string>

#include "onboard/changes/change_exports.hpp"
#include "onboard/changes/change_run.hpp"
#include "onboard/changes/command_words.hpp"

namespace {

using kawara::changes::Fail;

void Print(const kawara::core::ChangedObject& object) {
  const auto& box = object.box;
  const auto sd = [&](int i) { return std::sqrt(std::max(0.0, object.covariance(i, i))); };
  std::printf(
      "%-9s %s: %s, %.2f x %.2f x %.2f m (+-%.2f, %.2f, %.2f), heading %.1f deg (+-%.1f), centre "
      "%.2f east %.2f north (+-%.2f, %.2f), exists %.2f\n",
      ToString(object.state), object.uid.c_str(), ToString(object.size_class), box.size_m.x(),
      box.size_m.y(), box.size_m.z(), sd(3), sd(4), sd(5),
      box.heading_rad * kawara::core::kDegFromRad, sd(6) * kawara::core::kDegFromRad,
      box.centre_m.x(), box.centre_m.y(), sd(0), sd(1), object.existence_probability);
}

int Run(const kawara::changes::ChangeRunOptions& options, const std::string& exports) {
  const auto result = kawara::changes::RunChanges(options);
  if (!result) return Fail(result.error());
  for (const auto& revision : result->revisions) Print(revision);
  if (!exports.empty())
    if (const auto written = kawara::changes::WriteExports(options, *result, exports); !written)
      return Fail(written.error());
  std::printf(
      "kawara-changes: %zu objects stand (%zu told now); narrowest passable width %.2f m on %zu of "
      "%zu stations seen; %.1f s; %s\n",
      result->objects.size(), result->revisions.size(), result->narrowest_m, result->stations_seen,
      result->stations.size(), result->seconds, options.out.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Finds what stands on a road that the reference does not know, as boxes with their accuracy, "
      "and the width of road they leave; registers both as KIWI+ objects in a GeoPackage or "
      "PostGIS. Run again on later data it keeps the objects' ids, and closes what has gone."};
  kawara::changes::ChangeRunOptions options;
  std::string exports, origin, sensor, classes, time, method = "best";
  bool no_align = false;
  app.add_option("input", options.inputs,
                 "point clouds (PLY, LAS), or the folder of a model of kawara-mapper")
      ->required();
  app.add_option("--reference", options.reference, "file of kawara-reference");
  app.add_option("--road", options.roads,
                 "the road's area, if the reference has none: polygons of GeoJSON, GeoPackage, ...")
      ->expected(1, -1);
  app.add_option("--ground", options.ground, "raster of the ground's heights (GeoTIFF)");
  app.add_option("--geoid-separation", options.geoid_separation_m,
                 "added to the raster's heights, if they are above the sea [m]")
      ->check(CLI::Range(-120.0, 120.0));
  app.add_option("--out", options.out, "GeoPackage, or PG:... for PostGIS")->required();
  app.add_option("--exports", exports,
                 "folder for what stands now as GeoJSON, KMZ, CityJSON, VRML97, GLB, Cursor on "
                 "Target and the CSV twin of the KIWI+ tables");
  app.add_option("--road-name", options.road_name, "of the road's shapes only those of this name");
  app.add_option("--origin", origin,
                 "LATITUDE,LONGITUDE,HEIGHT of clouds in local metres [deg, deg, m]");
  app.add_flag("--local", options.local,
               "all files are in metres east, north, up of the map, whatever they say");
  app.add_option("--sensor", sensor, "EAST,NORTH,UP a cloud was taken from, if from one place [m]");
  app.add_option("--sd", options.cloud_sd_m, "one standard deviation of a cloud's points [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--voxel", options.voxel_m, "that clouds are gathered in [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 1.0));
  app.add_option("--method", method, "best, or paper: Meguro et al.'s subtraction and boxes")
      ->capture_default_str()
      ->check(CLI::IsMember({"best", "paper"}));
  app.add_option("--margin", options.finder.change.margin_m, "looked at beyond the road's edge [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 3.0));
  app.add_option("--min-height", options.finder.change.min_height_m,
                 "above the ground: what is lower can be driven over [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 2.0));
  app.add_option("--classes", classes, "widths that vehicles need [m], as 2.5,3,4");
  app.add_option("--survey", options.survey, "name of the survey; objects are SURVEY-1, ...")
      ->capture_default_str();
  app.add_option("--robot", options.robot, "who looked");
  app.add_option("--time", time, "of the look, ISO 8601; else when the input was last written");
  app.add_flag("--no-align", no_align,
               "neither measure nor take off how the map lies to the reference");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-changes --help tells more)", 2);
  }
  options.align = !no_align;
  options.say = [](const std::string& line) {
    std::fprintf(stderr, "kawara-changes: %s\n", line.c_str());
  };
  if (method == "paper") {
    const double margin_m = options.finder.change.margin_m;
    const double min_height_m = options.finder.change.min_height_m;
    options.finder = kawara::vision::PaperFinder();
    options.finder.change.margin_m = margin_m;
    options.finder.change.min_height_m = min_height_m;
  }
  if (!origin.empty()) {
    const auto parsed = kawara::changes::ParseOrigin(origin);
    if (!parsed) return Fail("--origin " + parsed.error().message, 2);
    options.origin = *parsed;
  }
  if (!sensor.empty()) {
    const auto parsed = kawara::changes::ParseNumbers(sensor);
    if (!parsed || parsed->size() != 3)
      return Fail("--sensor: expected EAST,NORTH,UP in metres", 2);
    options.sensor_m = Eigen::Vector3d((*parsed)[0], (*parsed)[1], (*parsed)[2]);
  }
  if (!classes.empty()) {
    const auto parsed = kawara::changes::ParseNumbers(classes);
    if (!parsed || !std::is_sorted(parsed->begin(), parsed->end()) || parsed->front() <= 0.0)
      return Fail("--classes: expected ascending widths in metres, as 2.5,3,4", 2);
    options.finder.width.classes_m = *parsed;
  }
  const auto when = kawara::changes::TimeOr(time, options.inputs.front().string());
  if (!when) return Fail((time.empty() ? "" : "--time ") + when.error().message, 2);
  options.time = *when;
  return Run(options, exports);
}
