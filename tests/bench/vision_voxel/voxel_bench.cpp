#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <random>
#include <unordered_map>
#include <vector>
#ifdef KAWARA_HAVE_OCTOMAP
#include <octomap/octomap.h>
#endif

#include "tests/support/box_world.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/voxel/voxel_map.hpp"

/// Votes a second in one core: 40 panoramic distance images of 1024 x 240 a metre apart down a
/// street with houses, poles and two vehicles; sd = 0.00767 range^2 / m (the paper's 151 mm over
/// 2-6 m), 3 % outliers, ranges to 20 m. Beside the map of this project, which gets ranges and
/// poses and keeps centroid, weight, colour and view, stand others that get points in the map's
/// frame and keep counts (OctoMap: its occupancy).
namespace kawara::vision {
namespace {

constexpr int kPictures = 40;
constexpr double kReachM = 20.0;

struct Load {
  std::unique_ptr<EquirectangularCamera> camera;
  std::unique_ptr<CameraRays> rays;
  std::vector<testing::BoxWorldView> looks;
  std::vector<std::vector<Eigen::Vector3f>> points;  ///< of each picture, map frame [m]
};

const Load& TheLoad() {
  static const Load load = [] {
    Load l;
    PanoramaGeometry geometry = PanoramaGeometry::Full(1024, 512);
    l.camera = std::make_unique<EquirectangularCamera>(*EquirectangularCamera::Create(geometry));
    l.rays = std::make_unique<CameraRays>(*l.camera);
    testing::BoxWorld world;
    for (int i = 0; i < 6; ++i) {
      world.boxes.emplace_back(Eigen::Vector3d(-20 + 14 * i, 6, 0),
                               Eigen::Vector3d(-9 + 14 * i, 16, 5 + i % 3));
      world.boxes.emplace_back(Eigen::Vector3d(-18 + 14 * i, -19, 0),
                               Eigen::Vector3d(-6 + 14 * i, -9, 4 + i % 2));
      world.boxes.emplace_back(Eigen::Vector3d(-15 + 14 * i, 4.9, 0),
                               Eigen::Vector3d(-14.7 + 14 * i, 5.2, 8));
    }
    world.boxes.emplace_back(Eigen::Vector3d(8, -4.6, 0), Eigen::Vector3d(15.6, -2.4, 3));
    world.boxes.emplace_back(Eigen::Vector3d(24, -4.1, 0), Eigen::Vector3d(28.6, -2.4, 1.5));
    std::mt19937_64 random(1);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    for (int i = 0; i < kPictures; ++i) {
      auto look = testing::LookAt(
          world, *l.camera, testing::UprightCamera({1.0 * i, 0.0, 2.0}, 1.57),
          [](double r) { return 0.00767 * r * r; }, random);
      auto& points = l.points.emplace_back();
      for (std::size_t p = 0; p < look.ranges.range_m.size(); ++p) {
        float& range = look.ranges.range_m[p];
        // 1024 x 240: the rows from +30 to -54 degrees.
        const auto row = static_cast<int>(p / 1024);
        if (row < 170 || row >= 410) range = RangeImage::kUnknown;
        if (std::isnan(range)) continue;
        if (uniform(random) < 0.03F) range = 1.0F + 19.0F * uniform(random);
        if (!(range > 0.3F && range <= static_cast<float>(kReachM))) {
          range = RangeImage::kUnknown;
          continue;
        }
        points.emplace_back(
            (look.map_from_camera * Eigen::Vector3d((l.rays->ray(p) * range).cast<double>()))
                .cast<float>());
      }
      l.looks.push_back(std::move(look));
    }
    return l;
  }();
  return load;
}

std::int64_t Points() {
  std::int64_t n = 0;
  for (const auto& points : TheLoad().points) n += static_cast<std::int64_t>(points.size());
  return n;
}

RangeView ViewOf(const testing::BoxWorldView& look) {
  return {.rays = *TheLoad().rays,
          .ranges = look.ranges,
          .picture = look.picture(),
          .map_from_camera = look.map_from_camera};
}

VoxelMap MapOf(const benchmark::State& state) {
  return *VoxelMap::Create({.voxel_m = static_cast<double>(state.range(0)) / 100.0,
                            .max_range_m = kReachM,
                            .max_sd_m = 10.0});
}

void Report(benchmark::State& state, std::size_t voxels, std::size_t bytes) {
  state.counters["Mpoints/s"] = benchmark::Counter(static_cast<double>(Points()) / 1e6,
                                                   benchmark::Counter::kIsIterationInvariantRate);
  state.counters["voxels"] = static_cast<double>(voxels);
  if (bytes > 0) state.counters["MB"] = static_cast<double>(bytes) / 1e6;
}

void BM_VoxelMap(benchmark::State& state) {
  TheLoad();
  std::size_t voxels = 0, bytes = 0;
  for (auto _ : state) {
    VoxelMap map = MapOf(state);
    for (const auto& look : TheLoad().looks)
      if (!map.Vote(ViewOf(look))) state.SkipWithError("refused");
    state.PauseTiming();
    voxels = 0;
    map.ForEachOccupied({.min_hits = 1, .min_hit_share = 0.0},
                        [&](const OccupiedVoxel&) { ++voxels; });
    bytes = map.memory_bytes();
    state.ResumeTiming();
  }
  Report(state, voxels, bytes);
}
BENCHMARK(BM_VoxelMap)->Arg(10)->Arg(20)->Arg(50)->ArgName("cm")->Unit(benchmark::kMillisecond);

void BM_SeeThrough(benchmark::State& state) {
  VoxelMap map = MapOf(state);
  for (const auto& look : TheLoad().looks)
    if (!map.Vote(ViewOf(look))) state.SkipWithError("refused");
  std::size_t i = 0;
  for (auto _ : state)
    if (!map.Examine(ViewOf(TheLoad().looks[i++ % kPictures]))) state.SkipWithError("refused");
}
BENCHMARK(BM_SeeThrough)->Arg(10)->Arg(20)->Arg(50)->ArgName("cm")->Unit(benchmark::kMillisecond);

void BM_UnorderedMap(benchmark::State& state) {
  const float scale = 100.0F / static_cast<float>(state.range(0));
  std::size_t voxels = 0;
  for (auto _ : state) {
    std::unordered_map<std::uint64_t, std::uint32_t> map;
    for (const auto& points : TheLoad().points) {
      for (const auto& p : points) {
        const auto key = [&](float v) {
          return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v * scale)) +
                                            (1 << 20));
        };
        ++map[(key(p.x()) << 42) | (key(p.y()) << 21) | key(p.z())];
      }
    }
    voxels = map.size();
  }
  Report(state, voxels, 0);
}
BENCHMARK(BM_UnorderedMap)->Arg(10)->Arg(20)->Arg(50)->ArgName("cm")->Unit(benchmark::kMillisecond);

#ifdef KAWARA_HAVE_OCTOMAP
void BM_OctoMap(benchmark::State& state) {
  std::size_t voxels = 0, bytes = 0;
  for (auto _ : state) {
    octomap::OcTree map(static_cast<double>(state.range(0)) / 100.0);
    for (const auto& points : TheLoad().points)
      for (const auto& p : points)
        map.updateNode(octomap::point3d(p.x(), p.y(), p.z()), true, true);
    state.PauseTiming();
    voxels = map.getNumLeafNodes();
    bytes = map.memoryUsage();
    state.ResumeTiming();
  }
  Report(state, voxels, bytes);
}
BENCHMARK(BM_OctoMap)->Arg(10)->Arg(20)->Arg(50)->ArgName("cm")->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace kawara::vision
