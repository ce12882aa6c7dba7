#include <benchmark/benchmark.h>

#include <memory>

#include "sim/render/range_scan.hpp"
#include "sim/render/renderer.hpp"
#include "sim/site/scene_builder.hpp"
#include "sim/site/site_config.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"

/// Frames a second of the committed factory road, shadows, body, noise and anti-aliasing included,
/// on all cores. Arguments: megapixels of the whole picture; rays a pixel at edges; 1: driving at
/// 1 m/s and turning 0.2 rad/s with 4 ms of exposure.
namespace kawara::sim {
namespace {

struct Site {
  SiteConfig config = *LoadSite(KAWARA_SOURCE_DIR "/configs/sites/factory_road.yaml");
  Terrain terrain{config};
  std::shared_ptr<const LitScene> lit =
      *LitScene::Create(BuildScene(config, terrain, SiteState::kAfter));
  Eigen::Vector3d eye{-33.6, -0.7, terrain.GroundHeight(-33.6, -0.7) + 1.45};
};
const Site& TheSite() {
  static const Site site;
  return site;
}

std::shared_ptr<const vision::CameraModel> Ring(double megapixels) {
  const int side_px = static_cast<int>(std::lround(std::sqrt(1e6 * megapixels)));
  return std::make_shared<vision::DoughnutCamera>(
      *vision::DoughnutCamera::Create(vision::DoughnutParameters().Resized(side_px, side_px)));
}

std::shared_ptr<const vision::CameraModel> Panorama(double megapixels) {
  const int height_px = static_cast<int>(std::lround(std::sqrt(1e6 * megapixels / 2.0)));
  return std::make_shared<vision::EquirectangularCamera>(*vision::EquirectangularCamera::Create(
      vision::PanoramaGeometry::Full(2 * height_px, height_px)));
}

template <class MakeCamera>
void Frames(benchmark::State& state, const MakeCamera& make) {
  CameraSettings settings;
  settings.samples = static_cast<int>(state.range(1));
  const Renderer renderer(TheSite().lit, make(static_cast<double>(state.range(0))), settings,
                          SurveyRobotBody());
  RenderRequest request;
  request.enu_from_camera = Still(UprightCamera(TheSite().eye, 1.4));
  if (state.range(2) != 0) {
    request.exposure_s = 0.004;
    request.enu_from_camera = [](double t) {
      return UprightCamera(TheSite().eye + Eigen::Vector3d(t, 0, 0), 1.4 + 0.2 * t);
    };
  }
  for (auto _ : state) benchmark::DoNotOptimize(renderer.Render(request));
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

void BM_Doughnut(benchmark::State& state) { Frames(state, Ring); }
void BM_Equirectangular(benchmark::State& state) { Frames(state, Panorama); }

void BM_LightOfASite(benchmark::State& state) {
  const Scene scene = BuildScene(TheSite().config, TheSite().terrain, SiteState::kAfter);
  for (auto _ : state) benchmark::DoNotOptimize(*LitScene::Create(scene));
}

void BM_LaserSweep(benchmark::State& state) {
  const RangeScanner scanner{RangeScannerSettings()};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = TheSite().eye;
  std::uint64_t seed = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(scanner.Scan(
        TheSite().lit->rays(), [&](double) { return pose; }, 0.0, ++seed));
  }
}

#define KAWARA_SIZES                        \
  Args({1, 3, 0})                           \
      ->Args({2, 1, 0})                     \
      ->Args({2, 3, 0})                     \
      ->Args({1, 3, 1})                     \
      ->Args({2, 3, 1})                     \
      ->Args({4, 3, 1})                     \
      ->Args({2, 5, 0})                     \
      ->ArgNames({"Mpx", "rays", "moving"}) \
      ->Unit(benchmark::kMillisecond)       \
      ->UseRealTime()
BENCHMARK(BM_Doughnut)->KAWARA_SIZES;
BENCHMARK(BM_Equirectangular)->KAWARA_SIZES;
BENCHMARK(BM_LightOfASite)->Unit(benchmark::kSecond)->UseRealTime()->Iterations(1);
BENCHMARK(BM_LaserSweep)->Unit(benchmark::kMicrosecond)->UseRealTime();

}  // namespace
}  // namespace kawara::sim
