#include "sim/render/renderer.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.hpp"
#include "sim/render/noise2.hpp"
#include "sim/render/packet_tracer.hpp"
#include "sim/render/shutter.hpp"

namespace kawara::sim {
namespace {

/// Rays a task works on; a multiple of a packet.
constexpr std::size_t kChunk = 1024;
/// Streaks are looked for no farther than this from what makes them.
constexpr float kLongestReach_px = 12.0F;
/// What dirt scatters, as a share of the light from an open sky.
constexpr float kVeilLight = 0.8F;

float Luminance(const Eigen::Array3f& rgb) {  // Source: ITU-R BT.709
  return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2];
}

/// Where in the pixel the i-th of `pairs` pairs lies (the other half of the pair is opposite): four
/// on a turned square, more on a spiral. Turned by quarters from pixel to pixel, so that neither
/// edges nor motion meet the same pattern everywhere.
Eigen::Vector2d PlaceInPixel(int i, int pairs, std::uint32_t pixel_hash) {
  Eigen::Vector2d place;
  if (pairs == 2) {
    place = i == 1 ? Eigen::Vector2d(0.375, 0.125) : Eigen::Vector2d(-0.125, 0.375);
  } else {
    const double radius = 0.5 * std::sqrt((i - 0.4) / pairs);
    const double angle = 0.6 + i * 2.399963;
    place = {radius * std::cos(angle), radius * std::sin(angle)};
  }
  for (std::uint32_t quarter = pixel_hash & 3U; quarter > 0; --quarter) {
    place = {-place.y(), place.x()};
  }
  return place;
}

}  // namespace

struct Renderer::Impl {
  std::shared_ptr<const vision::CameraModel> camera;
  CameraSettings settings;
  PacketTracer tracer;
  RayTable table;
  std::vector<std::uint8_t> may_meet_body;  ///< one a ray of the table
  Sensor sensor;
  Eigen::Array3f veil_light;

  Impl(std::shared_ptr<const LitScene> scene, std::shared_ptr<const vision::CameraModel> model,
       const CameraSettings& chosen, const RobotBody& body);
  template <class Work>
  void InChunks(std::size_t size, const Work& work) const;
  struct Exposing;
  void TraceCentres(Exposing& e, std::size_t first, std::size_t last) const;
  double BlurOf(const Exposing& e, std::size_t ray) const;
  void FindBlur(Exposing& e) const;
  int SamplesFor(const Exposing& e, std::size_t ray) const;
  void Refine(Exposing& e, std::size_t first, std::size_t last) const;
  void Develop(const Exposing& e, const RenderRequest& request, RenderedFrame& frame) const;
};

/// One frame on its way.
struct Renderer::Impl::Exposing {
  ShutterPoses poses;
  RayScene::Moment moment;
  std::vector<Eigen::Array3f> light;  ///< one a ray of the table
  std::vector<float> range_m;
  std::vector<std::uint32_t> object, key;
  std::vector<double> chunk_sum;
  std::vector<float> blur_px;  ///< empty: nothing moves during the exposure
  int streak_reach_px = 1;     ///< how far from its place anything's streak may be seen
};

Renderer::Impl::Impl(std::shared_ptr<const LitScene> scene,
                     std::shared_ptr<const vision::CameraModel> model, const CameraSettings& chosen,
                     const RobotBody& body)
    : camera(std::move(model)),
      settings(chosen),
      tracer(std::move(scene), body),
      table(RayTable::Build(*camera, settings.lens)),
      may_meet_body(table.rays.size(), 0),
      sensor(settings.sensor),
      veil_light(kVeilLight * tracer.scene().light().At({0, 0, 1e6}, {0, 0, 1})) {
  settings.samples = std::clamp(settings.samples, 1, 2 * ShutterPoses::kHalf + 1) | 1;
  settings.max_blur_samples =
      std::clamp(settings.max_blur_samples, 1, 2 * ShutterPoses::kHalf + 1) | 1;
  if (body.empty()) return;
  // A pixel meets the body, or its neighbour does: then its edge may cross the pixel.
  const int width = camera->width_px();
  const int height = camera->height_px();
  for (const PixelRay& ray : table.rays) {
    if (!tracer.MeetsBody(ray.direction_camera)) continue;
    for (int v = std::max(0, ray.v - 1); v <= std::min(height - 1, ray.v + 1); ++v) {
      for (int u = std::max(0, ray.u - 1); u <= std::min(width - 1, ray.u + 1); ++u) {
        const std::int32_t at = table.RayAt(u, v);
        if (at >= 0) may_meet_body[static_cast<std::size_t>(at)] = 1;
      }
    }
  }
}

template <class Work>
void Renderer::Impl::InChunks(std::size_t size, const Work& work) const {
  const std::size_t chunks = (size + kChunk - 1) / kChunk;
  const auto all = [&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chunks),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t c = range.begin(); c != range.end(); ++c) {
                          work(c, c * kChunk, std::min(size, (c + 1) * kChunk));
                        }
                      });
  };
  if (settings.threads == 1) {
    for (std::size_t c = 0; c < chunks; ++c) work(c, c * kChunk, std::min(size, (c + 1) * kChunk));
  } else if (settings.threads == 0) {
    all();
  } else {
    tbb::task_arena arena(std::min(settings.threads, tbb::info::default_concurrency()));
    arena.execute(all);
  }
}

// One ray through the centre of each pixel at the middle of its row's exposure: truth and light.
void Renderer::Impl::TraceCentres(Exposing& e, std::size_t first, std::size_t last) const {
  PacketTracer::Rays rays;
  PacketTracer::Traced traced;
  for (std::size_t start = first; start < last; start += kPacketRays) {
    const int count = static_cast<int>(std::min<std::size_t>(kPacketRays, last - start));
    for (int lane = 0; lane < count; ++lane) {
      const std::size_t number = start + static_cast<std::size_t>(lane);
      const PixelRay& pixel = table.rays[number];
      rays[static_cast<std::size_t>(lane)] = {pixel.direction_camera, &e.poses.At(pixel.v, 0),
                                              pixel.pixel_rad, may_meet_body[number] != 0};
    }
    tracer.Trace(rays, count, e.moment, traced);
    for (int lane = 0; lane < count; ++lane) {
      const std::size_t number = start + static_cast<std::size_t>(lane);
      const TracedRay& t = traced[static_cast<std::size_t>(lane)];
      e.light[number] = t.light;
      e.range_m[number] = t.range_m;
      e.object[number] = t.object;
      e.key[number] = t.surface_key;
    }
  }
}

// How far the place a pixel sees wanders over the picture while the shutter is open [px].
double Renderer::Impl::BlurOf(const Exposing& e, std::size_t number) const {
  if (e.object[number] == kRobotBodyObject) return 0.0;
  const PixelRay& pixel = table.rays[number];
  const ShutterPoses::Pose& middle = e.poses.At(pixel.v, 0);
  const Eigen::Vector3d ray = middle.R_enu_camera * pixel.direction_camera;
  const auto direction_at = [&](int instant) -> Eigen::Vector3d {
    const ShutterPoses::Pose& pose = e.poses.At(pixel.v, instant);
    Eigen::Vector3d to = ray;
    if (e.object[number] != 0) {
      to += (middle.origin_enu_m - pose.origin_enu_m) / static_cast<double>(e.range_m[number]);
    }
    return pose.R_enu_camera.transpose() * to.normalized();
  };
  return (direction_at(ShutterPoses::kHalf) - direction_at(-ShutterPoses::kHalf)).norm() /
         static_cast<double>(pixel.pixel_rad);
}

void Renderer::Impl::FindBlur(Exposing& e) const {
  e.blur_px.resize(table.rays.size());
  std::vector<float> longest(e.chunk_sum.size());
  InChunks(table.rays.size(), [&](std::size_t chunk, std::size_t first, std::size_t last) {
    for (std::size_t number = first; number < last; ++number) {
      e.blur_px[number] = static_cast<float>(BlurOf(e, number));
      longest[chunk] = std::max(longest[chunk], e.blur_px[number]);
    }
  });
  const float most = longest.empty() ? 0.0F : *std::max_element(longest.begin(), longest.end());
  if (static_cast<double>(most) <= settings.still_px) {
    e.blur_px.clear();
  } else {
    e.streak_reach_px = static_cast<int>(std::min(most / 2, kLongestReach_px)) + 1;
  }
}

// More than one where a neighbour shows another surface, where the picture moves, and where the
// streak of something near that moves may reach.
int Renderer::Impl::SamplesFor(const Exposing& e, std::size_t number) const {
  const PixelRay& pixel = table.rays[number];
  const int width = camera->width_px();
  int samples = 1;
  double blur_px = e.blur_px.empty() ? 0.0 : static_cast<double>(e.blur_px[number]);
  constexpr std::array<std::array<int, 2>, 8> kWays{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};
  for (int step = 1; step <= e.streak_reach_px; ++step) {
    for (std::size_t way = 0; way < (step == 1 && e.streak_reach_px == 1 ? 4U : 8U); ++way) {
      const int u = pixel.u + step * kWays[way][0];
      const int v = pixel.v + step * kWays[way][1];
      if (u < 0 || v < 0 || u >= width || v >= camera->height_px()) continue;
      const std::int32_t at = table.RayAt(u, v);
      if (at < 0) continue;
      const auto other = static_cast<std::size_t>(at);
      if (e.key[other] == e.key[number]) continue;
      if (step == 1 && way < 4) samples = settings.samples;
      if (!e.blur_px.empty() && e.blur_px[other] / 2 + 1 >= static_cast<float>(step)) {
        blur_px = std::max(blur_px, static_cast<double>(e.blur_px[other]));
      }
    }
  }
  if (blur_px > settings.still_px) {
    const int wanted = static_cast<int>(std::min(1.5 * blur_px, 64.0)) + 2;
    samples = std::max(samples, std::min(wanted | 1, settings.max_blur_samples));
  }
  return samples;
}

void Renderer::Impl::Refine(Exposing& e, std::size_t first, std::size_t last) const {
  PacketTracer::Rays rays;
  PacketTracer::Traced traced;
  std::array<std::size_t, kPacketRays> of{};
  int count = 0;
  std::array<Eigen::Array3f, kChunk> more;  // light of the further samples of this chunk
  std::array<int, kChunk> samples;
  const auto flush = [&] {
    tracer.Trace(rays, count, e.moment, traced);
    for (int lane = 0; lane < count; ++lane) {
      more[of[static_cast<std::size_t>(lane)] - first] +=
          traced[static_cast<std::size_t>(lane)].light;
    }
    count = 0;
  };
  for (std::size_t number = first; number < last; ++number) {
    samples[number - first] = SamplesFor(e, number);
    more[number - first] = Eigen::Array3f::Zero();
    const int pairs = samples[number - first] / 2;
    const PixelRay& pixel = table.rays[number];
    const std::uint32_t hash = HashCell(pixel.u, pixel.v, 77U);
    for (int i = 1; i <= pairs; ++i) {
      const Eigen::Vector2d place = PlaceInPixel(i, pairs, hash);
      const int instant = ShutterPoses::InstantOf(i, pairs);
      for (const int side : {1, -1}) {
        const auto direction = camera->Unproject(Eigen::Vector2d(pixel.u, pixel.v) + side * place);
        of[static_cast<std::size_t>(count)] = number;
        rays[static_cast<std::size_t>(count)] = {direction ? *direction : pixel.direction_camera,
                                                 &e.poses.At(pixel.v, side * instant),
                                                 pixel.pixel_rad, may_meet_body[number] != 0};
        if (++count == kPacketRays) flush();
      }
    }
  }
  if (count > 0) flush();
  for (std::size_t number = first; number < last; ++number) {
    const float share = 1.0F / static_cast<float>(samples[number - first]);
    e.light[number] = (e.light[number] + more[number - first]) * share;
  }
}

void Renderer::Impl::Develop(const Exposing& e, const RenderRequest& request,
                             RenderedFrame& frame) const {
  double sum = 0.0;
  for (const double part : e.chunk_sum) sum += part;
  frame.mean_light = table.rays.empty() ? 0.0 : sum / static_cast<double>(table.rays.size());
  frame.gain = sensor.GainFor(frame.mean_light);
  const auto gain = static_cast<float>(frame.gain);
  const auto expose = [&](const Eigen::Array3f& signal, std::size_t index) {
    sensor.Expose({signal[0], signal[1], signal[2]}, request.noise_seed,
                  static_cast<std::uint32_t>(index), &frame.rgb[3 * index]);
  };
  InChunks(table.rays.size(), [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t number = first; number < last; ++number) {
      const PixelRay& pixel = table.rays[number];
      const std::size_t index =
          static_cast<std::size_t>(pixel.v) * static_cast<std::size_t>(frame.width_px) + pixel.u;
      expose(gain * e.light[number], index);
      frame.range_m[index] = e.range_m[number];
      frame.object[index] = e.object[number];
    }
  });
  InChunks(table.surround.size(), [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t number = first; number < last; ++number) {
      const SurroundPixel& pixel = table.surround[number];
      expose(Eigen::Array3f::Constant(pixel.value), pixel.index);
    }
  });
}

Renderer::Renderer(std::shared_ptr<const LitScene> scene,
                   std::shared_ptr<const vision::CameraModel> camera,
                   const CameraSettings& settings, const RobotBody& body)
    : impl_(std::make_unique<const Impl>(std::move(scene), std::move(camera), settings, body)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

const vision::CameraModel& Renderer::camera() const { return *impl_->camera; }

RenderedFrame Renderer::Render(const RenderRequest& request) const {
  CORE_CHECK(request.enu_from_camera && request.exposure_s >= 0.0);
  RenderedFrame frame;
  frame.width_px = impl_->camera->width_px();
  frame.height_px = impl_->camera->height_px();
  const std::size_t pixels =
      static_cast<std::size_t>(frame.width_px) * static_cast<std::size_t>(frame.height_px);
  frame.rgb.resize(3 * pixels);
  frame.range_m.assign(pixels, std::numeric_limits<float>::quiet_NaN());
  frame.object.assign(pixels, 0);

  const std::size_t rays = impl_->table.rays.size();
  Impl::Exposing e{
      ShutterPoses(request.enu_from_camera, request.exposure_s, request.readout_s, frame.height_px),
      impl_->tracer.scene().rays().MomentAt(request.time_s),
      std::vector<Eigen::Array3f>(rays),
      std::vector<float>(rays),
      std::vector<std::uint32_t>(rays),
      std::vector<std::uint32_t>(rays),
      std::vector<double>((rays + kChunk - 1) / kChunk),
      {},
      1};
  impl_->InChunks(rays, [&](std::size_t, std::size_t first, std::size_t last) {
    impl_->TraceCentres(e, first, last);
  });
  if (request.exposure_s > 0.0) impl_->FindBlur(e);
  impl_->InChunks(rays, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    impl_->Refine(e, first, last);
    double sum = 0.0;
    for (std::size_t number = first; number < last; ++number) {
      const PixelRay& pixel = impl_->table.rays[number];
      e.light[number] = e.light[number] * pixel.through + pixel.veil * impl_->veil_light;
      sum += static_cast<double>(Luminance(e.light[number]));
    }
    e.chunk_sum[chunk] = sum;
  });
  impl_->Develop(e, request, frame);
  return frame;
}

Eigen::Isometry3d UprightCamera(const Eigen::Vector3d& place_enu_m, double heading_rad) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = Eigen::Vector3d::UnitZ();
  pose.linear().col(1) = Eigen::Vector3d(std::cos(heading_rad), -std::sin(heading_rad), 0.0);
  pose.linear().col(2) = Eigen::Vector3d(std::sin(heading_rad), std::cos(heading_rad), 0.0);
  pose.translation() = place_enu_m;
  return pose;
}

}  // namespace kawara::sim
