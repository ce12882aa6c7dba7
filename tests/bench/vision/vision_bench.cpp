#include <benchmark/benchmark.h>

#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/jpeg.hpp"
#include "vision/panorama.hpp"
#include "vision/panorama_metadata.hpp"
#include "vision/phase1_picture.hpp"
#include "vision/remap_table.hpp"

/// 2 Mpx panorama (3000 x 667) from a 1024 x 1024 and a 2048 x 2048 px ring; OpenCV's remap does
/// the same work beside it, from the same camera model, with its own fixed-point maps.
namespace kawara::vision {
namespace {

constexpr int kPanoramaWidthPx = 3000;

DoughnutParameters Ring(int size_px) {
  const double scale = size_px / 1024.0;
  DoughnutParameters p;
  p.width_px = p.height_px = size_px;
  p.center_u_px = p.center_v_px = 512.0 * scale - 0.5;
  p.l_in_px *= scale;
  p.l_base_px *= scale;
  p.l_out_px *= scale;
  return p;
}

std::vector<std::uint8_t> RealPanorama() {
  std::ifstream file(KAWARA_SOURCE_DIR "/data/panorama/R0014760_3072.jpg", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The real panorama seen through the mirror.
std::vector<std::uint8_t> RingPicture(int size_px) {
  JpegDecoder decoder;
  const auto bytes = RealPanorama();
  const auto panorama = decoder.Decode(bytes);
  const auto sphere = EquirectangularCamera::Create(
      PanoramaGeometry::Full(panorama->width_px, panorama->height_px));
  const auto ring = DoughnutCamera::Create(Ring(size_px));
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size_px * size_px * 3));
  RemapTable::Build(*sphere, *ring, Eigen::Matrix3d::Identity())
      ->Apply(*panorama, {pixels.data(), size_px, size_px});
  return pixels;
}

// What the camera delivers.
std::vector<std::uint8_t> RingFrame(int size_px) {
  const auto ring = RingPicture(size_px);
  JpegEncoder encoder;
  const auto jpeg = *encoder.Encode({ring.data(), size_px, size_px}, {.quality = 90});
  return {jpeg.begin(), jpeg.end()};
}

PanoramaUnwrapper MakeUnwrapper(int size_px, RemapFormat format = RemapFormat::kRgb) {
  PanoramaConfig config;
  config.width_px = kPanoramaWidthPx;
  return *PanoramaUnwrapper::Create(
      std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(Ring(size_px))), config, format);
}

void CountPixels(benchmark::State& state, const PanoramaGeometry& g) {
  state.counters["Mpx/s"] = benchmark::Counter(1e-6 * g.width_px * g.height_px,
                                               benchmark::Counter::kIsIterationInvariantRate);
}

void BM_Unwrap(benchmark::State& state) {
  const int size_px = static_cast<int>(state.range(0));
  const PanoramaUnwrapper unwrapper = MakeUnwrapper(size_px);
  const auto ring = RingPicture(size_px);
  const PanoramaGeometry g = unwrapper.geometry();
  std::vector<std::uint8_t> out(static_cast<std::size_t>(g.width_px * g.height_px * 3));
  for (auto _ : state) {
    unwrapper.Unwrap({ring.data(), size_px, size_px}, {out.data(), g.width_px, g.height_px});
    benchmark::ClobberMemory();
  }
  CountPixels(state, g);
  state.counters["samples/px"] = unwrapper.table().mean_samples();
}
BENCHMARK(BM_Unwrap)->Arg(1024)->Arg(2048)->Unit(benchmark::kMillisecond);

void BM_UnwrapPlanes(benchmark::State& state) {
  const int size_px = static_cast<int>(state.range(0));
  const PanoramaUnwrapper unwrapper = MakeUnwrapper(size_px, RemapFormat::kPlane);
  const auto ring = RingPicture(size_px);
  const PanoramaGeometry g = unwrapper.geometry();
  Yuv420Buffer source, target;
  const Yuv420View planes = source.View(size_px, size_px);
  Yuv420FromRgb({ring.data(), size_px, size_px}, planes);
  for (auto _ : state) {
    unwrapper.UnwrapYuv420(planes, target.View(g.width_px, g.height_px));
    benchmark::ClobberMemory();
  }
  CountPixels(state, g);
}
BENCHMARK(BM_UnwrapPlanes)->Arg(1024)->Arg(2048)->Unit(benchmark::kMillisecond);

// One bilinear sample a pixel, single thread: the same work as BM_Unwrap/1024; at 2048 OpenCV does
// less (it aliases).
void BM_OpenCvRemap(benchmark::State& state) {
  cv::setNumThreads(1);
  const int size_px = static_cast<int>(state.range(0));
  const PanoramaUnwrapper unwrapper = MakeUnwrapper(size_px);
  const auto camera = DoughnutCamera::Create(Ring(size_px));
  auto ring = RingPicture(size_px);
  const PanoramaGeometry g = unwrapper.geometry();
  const auto target = EquirectangularCamera::Create(g);
  cv::Mat map(g.height_px, g.width_px, CV_32FC2), coordinates, weights;
  for (int v = 0; v < g.height_px; ++v) {
    for (int u = 0; u < g.width_px; ++u) {
      const auto pixel = camera->Project(*target->Unproject({u, v}));
      map.at<cv::Vec2f>(v, u) =
          pixel ? cv::Vec2f(static_cast<float>(pixel->x()), static_cast<float>(pixel->y()))
                : cv::Vec2f(-9, -9);
    }
  }
  cv::convertMaps(map, cv::noArray(), coordinates, weights, CV_16SC2);
  const cv::Mat source(size_px, size_px, CV_8UC3, ring.data());
  cv::Mat out;
  for (auto _ : state) {
    cv::remap(source, out, coordinates, weights, cv::INTER_LINEAR);
    benchmark::ClobberMemory();
  }
  CountPixels(state, g);
}
BENCHMARK(BM_OpenCvRemap)->Arg(1024)->Arg(2048)->Unit(benchmark::kMillisecond);

void BM_BuildTable(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(MakeUnwrapper(1024));
}
BENCHMARK(BM_BuildTable)->Unit(benchmark::kMillisecond);

void BM_EncodePanorama(benchmark::State& state) {
  const PanoramaUnwrapper unwrapper = MakeUnwrapper(1024);
  const auto ring = RingPicture(1024);
  const PanoramaGeometry g = unwrapper.geometry();
  std::vector<std::uint8_t> out(static_cast<std::size_t>(g.width_px * g.height_px * 3));
  unwrapper.Unwrap({ring.data(), 1024, 1024}, {out.data(), g.width_px, g.height_px});
  JpegEncoder encoder;
  std::size_t bytes = 0;
  for (auto _ : state) {
    bytes =
        encoder.Encode({out.data(), g.width_px, g.height_px}, {.progressive = state.range(0) != 0})
            ->size();
  }
  CountPixels(state, g);
  state.counters["bytes"] = static_cast<double>(bytes);
}
BENCHMARK(BM_EncodePanorama)->ArgName("progressive")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void BM_InsertMetadata(benchmark::State& state) {
  const auto jpeg = RealPanorama();
  PanoramaMetadata m;
  m.time = core::UtcTime::FromNs(1'000'000'000'000'000'000);
  m.position = core::Geodetic{0.6, 2.4, 50};
  m.attitude = core::Attitude{};
  m.geometry = PanoramaGeometry::Full(3072, 1536);
  std::vector<std::uint8_t> out;
  for (auto _ : state) benchmark::DoNotOptimize(InsertPanoramaMetadata(jpeg, m, &out));
}
BENCHMARK(BM_InsertMetadata)->Unit(benchmark::kMicrosecond);

// One frame's picture job, camera's JPEG to preview and full panorama; `preview` alone says when
// the first of them is there. Two frames take turns: none is known from the round before.
void BM_Phase1Picture(benchmark::State& state) {
  const int size_px = static_cast<int>(state.range(0));
  const bool full = state.range(1) != 0;
  Phase1PictureConfig config;
  config.doughnut = Ring(size_px);
  config.panorama.width_px = kPanoramaWidthPx;
  auto job = Phase1Picture::Create(config);
  const auto one = RingFrame(size_px);
  auto other = one;
  other.push_back(0);
  const SourceFrame frames[] = {{.bytes = one}, {.bytes = other}};
  int turn = 0;
  for (auto _ : state) {
    const SourceFrame& frame = frames[turn++ % 2];
    benchmark::DoNotOptimize(job->Preview(frame));
    if (full) benchmark::DoNotOptimize(job->Full(frame));
  }
}
BENCHMARK(BM_Phase1Picture)
    ->ArgNames({"ring", "full"})
    ->ArgsProduct({{1024, 2048}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

// The same two pictures by way of RGB: reduced decoding for the preview, whole for the full one.
void BM_Phase1PictureByRgb(benchmark::State& state) {
  const int size_px = static_cast<int>(state.range(0));
  const bool full = state.range(1) != 0;
  const int eighths = 2048 * 2 / size_px;
  PanoramaConfig small;
  small.width_px = 512;
  const PanoramaUnwrapper preview = *PanoramaUnwrapper::Create(
      std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(Ring(size_px).Scaled(eighths))),
      small);
  const PanoramaUnwrapper unwrapper = MakeUnwrapper(size_px);
  const auto frame = RingFrame(size_px);
  JpegDecoder decoder;
  JpegEncoder encoder;
  std::vector<std::uint8_t> pixels;
  const auto make = [&](const PanoramaUnwrapper& unwrap, int scale_eighths, int quality) {
    const PanoramaGeometry& g = unwrap.geometry();
    pixels.resize(static_cast<std::size_t>(g.width_px * g.height_px * 3));
    const ImageView target{pixels.data(), g.width_px, g.height_px};
    unwrap.Unwrap(*decoder.Decode(frame, {.scale_eighths = scale_eighths}), target);
    benchmark::DoNotOptimize(encoder.Encode(target, {.quality = quality}));
  };
  for (auto _ : state) {
    make(preview, eighths, 50);
    if (full) make(unwrapper, 8, 85);
  }
}
BENCHMARK(BM_Phase1PictureByRgb)
    ->ArgNames({"ring", "full"})
    ->ArgsProduct({{1024, 2048}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kawara::vision
