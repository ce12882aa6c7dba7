#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <optional>

#include "core/geodesy.hpp"
#include "sim/render/frame_files.hpp"
#include "sim/render/light_cache.hpp"
#include "sim/site/scene_builder.hpp"
#include "sim/site/site_config.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/panorama.hpp"

namespace {

using namespace kawara;

struct Options {
  std::string site;
  std::string out = "view";
  std::vector<double> at_m;
  std::optional<double> heading_deg;
  double along = 0.3;
  double height_m = 1.45;
  double time_s = 0.0;
  int size_px = 1414;
  bool panorama = false;
  bool before = false;
  bool no_body = false;
  bool truth = false;
  sim::CameraSettings camera;
};

void AddOptions(CLI::App& app, Options& o) {
  app.add_option("--site", o.site, "site file, as configs/sites/factory_road.yaml")->required();
  app.add_option("--out", o.out, "first part of the names of the files written")
      ->capture_default_str();
  app.add_option("--along", o.along, "where on the site's path, 0 to 1")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--at", o.at_m, "EAST NORTH [m] instead")->expected(2);
  app.add_option("--heading", o.heading_deg, "degrees from north; without it along the path");
  app.add_option("--height", o.height_m, "of the camera over the ground [m]")
      ->capture_default_str();
  app.add_option("--time", o.time_s, "seconds of the mission: which objects are there")
      ->capture_default_str();
  app.add_option("--size", o.size_px, "side of the ring's picture, or width of the panorama [px]")
      ->check(CLI::Range(64, 8192))
      ->capture_default_str();
  app.add_option("--samples", o.camera.samples, "rays a pixel at edges (1, 3, 5 ...)")
      ->check(CLI::Range(1, 17))
      ->capture_default_str();
  app.add_flag("--panorama", o.panorama,
               "a full equirectangular picture instead of the ring and its unwrapped panorama");
  app.add_flag("--before", o.before, "the site as the reference knows it");
  app.add_flag("--no-body", o.no_body, "without the robot's own body in view");
  app.add_flag("--truth", o.truth, "also OUT_range.pfm, OUT_range.png (mm) and OUT_objects.png");
}

/// A place on the site's path and the way it leads there.
Eigen::Vector3d PlaceOnPath(const sim::SiteConfig& site, double along) {
  double length_m = 0.0;
  const auto point = [&](std::size_t i) {
    return Eigen::Vector2d(site.path.points[i].at_m[0], site.path.points[i].at_m[1]);
  };
  for (std::size_t i = 1; i < site.path.points.size(); ++i) {
    length_m += (point(i) - point(i - 1)).norm();
  }
  double left_m = along * length_m;
  for (std::size_t i = 1;; ++i) {
    const Eigen::Vector2d step = point(i) - point(i - 1);
    if (left_m <= step.norm() || i + 1 == site.path.points.size()) {
      const Eigen::Vector2d place = point(i - 1) + step * (left_m / std::max(step.norm(), 1e-9));
      return {place.x(), place.y(), std::atan2(step.x(), step.y())};
    }
    left_m -= step.norm();
  }
}

core::Expected<void> WriteAll(const Options& o, const sim::RenderedFrame& frame,
                              std::shared_ptr<const vision::CameraModel> camera) {
  if (auto good = sim::WriteColour(frame, o.out + ".jpg"); !good) return good;
  if (!o.panorama) {
    vision::PanoramaConfig config;
    config.width_px = 2048;
    const auto unwrapper = vision::PanoramaUnwrapper::Create(std::move(camera), config);
    if (!unwrapper) return tl::unexpected(unwrapper.error());
    sim::RenderedFrame flat;
    flat.width_px = unwrapper->geometry().width_px;
    flat.height_px = unwrapper->geometry().height_px;
    flat.rgb.resize(flat.view().size_bytes());
    unwrapper->Unwrap(frame.view(), {flat.rgb.data(), flat.width_px, flat.height_px});
    if (auto good = sim::WriteColour(flat, o.out + "_panorama.jpg"); !good) return good;
  }
  if (!o.truth) return {};
  if (auto good = sim::WriteRangePfm(frame, o.out + "_range.pfm"); !good) return good;
  if (auto good = sim::WriteRangePng(frame, o.out + "_range.png"); !good) return good;
  return sim::WriteObjectsPng(frame, o.out + "_objects.png");
}

core::Expected<void> Run(const Options& o) {
  const auto site = sim::LoadSite(o.site);
  if (!site) return tl::unexpected(site.error());
  const sim::Terrain terrain(*site);
  const sim::Scene scene =
      sim::BuildScene(*site, terrain, o.before ? sim::SiteState::kBefore : sim::SiteState::kAfter);
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const Clock::time_point start = Clock::now();
  sim::LightSettings light;
  light.cache = sim::LightCache::DefaultFolder();
  const auto lit = sim::LitScene::Create(scene, light);
  if (!lit) return tl::unexpected(lit.error());
  std::printf("%zu triangles, light at %zu points %.2f m apart: %.1f s\n",
              (*lit)->rays().triangle_count(), (*lit)->light().point_count(),
              static_cast<double>((*lit)->light().cell_m()), seconds_since(start));

  std::shared_ptr<const vision::CameraModel> camera;
  if (o.panorama) {
    const auto made = vision::EquirectangularCamera::Create(
        vision::PanoramaGeometry::Full(o.size_px, o.size_px / 2));
    if (!made) return tl::unexpected(made.error());
    camera = std::make_shared<vision::EquirectangularCamera>(*made);
  } else {
    const auto made =
        vision::DoughnutCamera::Create(vision::DoughnutParameters().Resized(o.size_px, o.size_px));
    if (!made) return tl::unexpected(made.error());
    camera = std::make_shared<vision::DoughnutCamera>(*made);
  }
  const sim::Renderer renderer(*lit, camera, o.camera,
                               o.no_body ? sim::RobotBody{} : sim::SurveyRobotBody());
  Eigen::Vector3d place = PlaceOnPath(*site, o.along);
  if (!o.at_m.empty()) place.head<2>() = Eigen::Vector2d(o.at_m[0], o.at_m[1]);
  if (o.heading_deg) place.z() = *o.heading_deg * core::kRadFromDeg;
  const double up_m = terrain.GroundHeight(place.x(), place.y()) + o.height_m;
  sim::RenderRequest request;
  request.enu_from_camera = sim::Still(sim::UprightCamera({place.x(), place.y(), up_m}, place.z()));
  request.time_s = o.time_s;
  const Clock::time_point before_frame = Clock::now();
  const sim::RenderedFrame frame = renderer.Render(request);
  std::printf("%s: %d x %d px at east %.1f m, north %.1f m, heading %.0f deg: %.2f s\n",
              o.out.c_str(), frame.width_px, frame.height_px, place.x(), place.y(),
              place.z() * core::kDegFromRad, seconds_since(before_frame));
  return WriteAll(o, frame, camera);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Renders what the robot's camera sees at a place of a simulated site."};
  Options options;
  AddOptions(app, options);
  CLI11_PARSE(app, argc, argv);
  if (const auto done = Run(options); !done) {
    std::fprintf(stderr, "kawara-render: %s\n", done.error().message.c_str());
    return 2;
  }
  return 0;
}
