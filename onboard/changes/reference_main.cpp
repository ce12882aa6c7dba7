// kawara-reference: the model of a place before, that changes are found against.
#include <CLI/CLI.hpp>
#include <cinttypes>
#include <cstdio>
#include <string>

#include "gis/model/whole_file.hpp"
#include "onboard/changes/command_words.hpp"
#include "onboard/changes/reference_run.hpp"
#include "vision/change/reference_file.hpp"

namespace {

using kawara::changes::Fail;

int Show(const std::string& file) {
  const auto reference = kawara::vision::ReadReference(file);
  if (!reference) return Fail(reference.error());
  std::fputs(kawara::changes::Describe(*reference).c_str(), stdout);
  return 0;
}

int Build(const kawara::changes::ReferenceOptions& options, const std::string& out) {
  const auto result = kawara::changes::BuildReference(options);
  if (!result) return Fail(result.error());
  const auto bytes = kawara::vision::EncodeReference(result->map);
  const auto written =
      kawara::gis::WriteWholeFile(out, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!written) return Fail(written.error());
  std::fputs(kawara::changes::Describe(result->map).c_str(), stdout);
  std::printf("kawara-reference: %" PRIu64 " points and %zu buildings in %.1f MB; %s\n",
              result->cloud_points, result->buildings, 1e-6 * static_cast<double>(bytes.size()),
              out.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Makes the reference that kawara-changes compares with: surfaces in 50 cm voxels with their "
      "planes, the ground and the road, each with its accuracy and date, in one file."};
  kawara::changes::ReferenceOptions options;
  std::string out, show, origin, date;
  app.add_option("--out", out, "file to write");
  app.add_option("--show", show, "says what a reference holds");
  app.add_option("--cloud", options.clouds,
                 "points of laser scanners, or of an earlier drive's model: PLY, LAS")
      ->expected(1, -1);
  app.add_option("--cloud-sd", options.cloud_sd_m, "one standard deviation of their points [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 5.0));
  app.add_option("--buildings", options.buildings,
                 "CityJSON, CityGML (PLATEAU), or footprints with a height: GeoJSON, GeoPackage, "
                 "Shapefile")
      ->expected(1, -1);
  app.add_option("--building-sd", options.building_sd_m,
                 "of their walls and roofs [m]; else as the file says, or by its level of detail")
      ->check(CLI::Range(0.001, 20.0));
  app.add_option("--height-field", options.height_field, "of footprints: the field of the height");
  app.add_option("--ground", options.ground, "raster of heights, GeoTIFF or any of GDAL's");
  app.add_option("--ground-sd", options.ground_sd_m, "of its heights [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 20.0));
  app.add_option("--geoid-separation", options.geoid_separation_m,
                 "added to the raster's heights, if they are above the sea [m]")
      ->check(CLI::Range(-120.0, 120.0));
  app.add_option(
         "--road", options.roads,
         "the road's area: polygons of GeoJSON, GeoPackage, CityGML; lines are taken as its "
         "middle")
      ->expected(1, -1);
  app.add_option("--road-name", options.road_name, "of the road's shapes only those of this name");
  app.add_option("--origin", origin,
                 "of the map: the folder of a model of kawara-mapper, or LATITUDE,LONGITUDE,HEIGHT "
                 "[deg, deg, m above the ellipsoid]; else the first file's that has one");
  app.add_flag("--local", options.local,
               "the files are in metres east, north, up of the map, whatever they say");
  app.add_option("--date", date, "when all this was true, ISO 8601");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-reference --help tells more)", 2);
  }
  if (!show.empty()) return Show(show);
  if (out.empty()) return Fail("--out FILE is required (kawara-reference --help tells more)", 2);
  if (options.clouds.empty() && options.buildings.empty() && options.ground.empty() &&
      options.roads.empty())
    return Fail("nothing to make it from: --cloud, --buildings, --ground or --road", 2);
  if (!origin.empty()) {
    const auto parsed = kawara::changes::ParseOrigin(origin);
    if (!parsed) return Fail("--origin " + parsed.error().message, 2);
    options.origin = *parsed;
  }
  if (!date.empty()) {
    const auto parsed = kawara::changes::ParseTime(date);
    if (!parsed) return Fail("--date " + parsed.error().message, 2);
    options.date = *parsed;
  }
  options.say = [](const std::string& line) {
    std::fprintf(stderr, "kawara-reference: %s\n", line.c_str());
  };
  return Build(options, out);
}
