#include <benchmark/benchmark.h>

#include "tests/support/box_world.hpp"
#include "tests/support/painted_box.hpp"
#include "tests/support/test_doughnut.hpp"
#include "vision/sides/side_texture.hpp"

/// The textures of a truck of 7.6 x 2.2 x 3.0 m, four sides and the top all wanted at 2 cm, from 20
/// doughnut pictures of 1024 x 1024 px with distance images of half the size, 2 m apart on a way
/// past it at 2.4 m. One core.
namespace kawara::vision {
namespace {

void BM_TruckFromTwentyViews(benchmark::State& state) {
  const auto camera = *DoughnutCamera::Create(TestDoughnut());
  core::ChangedObject truck;
  truck.uid = "truck-1";
  truck.box = {.centre_m = {0, 0, 1.5}, .size_m = {7.6, 2.2, 3.0}, .heading_rad = 1.57};
  truck.side_seen.fill(true);
  testing::PaintedBox world;
  world.box = truck.box;
  std::vector<testing::PaintedView> looks;
  std::vector<RangeImage> ranges;
  for (int i = 0; i < 20; ++i) {
    looks.push_back(world.LookAt(
        camera,
        testing::UprightCamera({-19.0 + 2.0 * i, -3.5, state.range(0) != 0 ? 3.6 : 1.5}, 1.57)));
    ranges.push_back(RangesForTexture(looks.back().ranges));
  }
  std::vector<SideView> views;
  for (std::size_t i = 0; i < looks.size(); ++i)
    views.push_back({.view = {.camera = camera,
                              .picture = looks[i].picture(),
                              .ranges = &ranges[i],
                              .map_from_camera = looks[i].map_from_camera},
                     .source = "m1/" + std::to_string(i)});
  JpegEncoder encoder;
  core::ObjectTextures textures;
  for (auto _ : state) textures = MakeSideTextures(truck, views, {}, encoder).value();
  state.counters["faces"] = static_cast<double>(textures.faces.size());
  state.counters["atlas_kB"] = 1e-3 * static_cast<double>(textures.atlas_jpeg.size());
  state.counters["atlas_px"] = textures.width_px * textures.height_px;
}
// 0: from 1.5 m above the road; 1: from above its top.
BENCHMARK(BM_TruckFromTwentyViews)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kawara::vision
