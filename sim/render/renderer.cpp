#include "sim/render/renderer.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.hpp"
#include "sim/render/first_look.hpp"
#include "sim/render/noise2.hpp"
#include "sim/render/packet_tracer.hpp"
#include "sim/render/shutter.hpp"

namespace kawara::sim {
namespace {

/// Rays a task works on; a multiple of a packet.
constexpr std::size_t kChunk = 1024;
/// Streaks are looked for no farther than this from what makes them.
constexpr float kLongestReach_px = 12.0F;
/// A row of blocks counts as so many rays when work is shared out; a divisor of kChunk.
constexpr std::size_t kBlockRowsShare = 128;
/// Directions further apart are no longer told by tangents.
constexpr float kMostBlur_px = 48.0F;
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
  struct Sample;
  void TraceCentres(Exposing& e, std::size_t first, std::size_t last) const;
  void SumUpBlocks(Exposing& e) const;
  Eigen::Vector2f BlurOf(const Exposing& e, std::size_t ray) const;
  void FindBlur(Exposing& e) const;
  struct Plan;
  Plan PlanFor(const Exposing& e, std::size_t ray) const;
  Eigen::Array3f Smeared(const Exposing& e, std::size_t ray, int samples) const;
  bool SeenBefore(const Exposing& e, const Sample& sample, const Sight& sight,
                  Eigen::Array3f& light) const;
  void Refine(Exposing& e, std::size_t first, std::size_t last) const;
  std::size_t IndexOf(const PixelRay& pixel) const {
    return static_cast<std::size_t>(pixel.v) * static_cast<std::size_t>(table.width_px) + pixel.u;
  }
  void Develop(const Exposing& e, const RenderRequest& request, RenderedFrame& frame) const;
};

/// One frame on its way.
struct Renderer::Impl::Exposing {
  ShutterPoses poses;
  RayScene::Moment moment;
  RenderedFrame& frame;  ///< gets its truth from the first look
  FirstLook first;
  std::vector<Eigen::Array3f> light;  ///< one a ray of the table
  std::vector<double> chunk_sum;
  /// One a ray: how far what it sees wanders over the picture while the shutter is open. Empty:
  /// nothing moves.
  std::vector<Eigen::Vector2f> blur_px;
  int streak_reach_px = 1;  ///< how far from its place anything's streak may be seen
};

/// What a pixel needs beyond its first look.
struct Renderer::Impl::Plan {
  int samples = 1;     ///< with the first
  bool mixed = false;  ///< other surfaces have a share in it
};

/// One more look of a pixel.
struct Renderer::Impl::Sample {
  std::size_t number = 0;  ///< of the ray
  Eigen::Vector2f off_px;  ///< from the pixel's centre
  const ShutterPoses::Pose* pose = nullptr;
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
  PacketTracer::Sights sights;
  PacketTracer::Lights light;
  LitScene::Memory memory;
  for (std::size_t start = first; start < last; start += kPacketRays) {
    const int count = static_cast<int>(std::min<std::size_t>(kPacketRays, last - start));
    for (int lane = 0; lane < count; ++lane) {
      const std::size_t number = start + static_cast<std::size_t>(lane);
      const PixelRay& pixel = table.rays[number];
      rays[static_cast<std::size_t>(lane)] = {pixel.direction_camera, &e.poses.At(pixel.v, 0),
                                              pixel.pixel_rad, may_meet_body[number] != 0};
    }
    tracer.Trace(rays, count, e.moment, sights);
    tracer.Shade(sights, (1U << count) - 1U, e.moment, memory, light);
    for (int lane = 0; lane < count; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      const PixelRay& pixel = table.rays[start + l];
      const std::size_t index = IndexOf(pixel);
      e.frame.range_m[index] = static_cast<float>(sights[l].hit.range_m);
      e.frame.object[index] = sights[l].hit.object;
      e.first.Set(pixel.u, pixel.v, light[l], sights[l].surface_key);
    }
  }
}

void Renderer::Impl::SumUpBlocks(Exposing& e) const {
  InChunks(static_cast<std::size_t>(e.first.block_rows()) * kBlockRowsShare,
           [&](std::size_t, std::size_t first, std::size_t last) {
             for (std::size_t i = first; i < last; i += kBlockRowsShare) {
               e.first.SumUpBlocks(static_cast<int>(i / kBlockRowsShare));
             }
           });
}

Eigen::Vector2f Renderer::Impl::BlurOf(const Exposing& e, std::size_t number) const {
  const PixelRay& pixel = table.rays[number];
  const std::size_t index = IndexOf(pixel);
  if (e.frame.object[index] == kRobotBodyObject) return Eigen::Vector2f::Zero();
  const Eigen::Vector3f ray = pixel.direction_camera.cast<float>();
  const auto at = [&](int instant) {
    return e.poses.At(pixel.v, instant).SeenFromHere(ray, e.frame.range_m[index]);
  };
  const Eigen::Vector3f change = at(ShutterPoses::kHalf) - at(-ShutterPoses::kHalf);
  const Eigen::Vector2f blur_px = table.tangents[number].PixelsTo(change);
  return blur_px.squaredNorm() < kMostBlur_px * kMostBlur_px
             ? blur_px
             : Eigen::Vector2f(change.norm() / pixel.pixel_rad, 0.0F);
}

void Renderer::Impl::FindBlur(Exposing& e) const {
  e.blur_px.resize(table.rays.size());
  std::vector<float> longest(e.chunk_sum.size());
  InChunks(table.rays.size(), [&](std::size_t chunk, std::size_t first, std::size_t last) {
    for (std::size_t number = first; number < last; ++number) {
      e.blur_px[number] = BlurOf(e, number);
      longest[chunk] = std::max(longest[chunk], e.blur_px[number].squaredNorm());
    }
  });
  const float most =
      longest.empty() ? 0.0F : std::sqrt(*std::max_element(longest.begin(), longest.end()));
  if (static_cast<double>(most) <= settings.still_px) {
    e.blur_px.clear();
  } else {
    e.streak_reach_px = static_cast<int>(std::min(most / 2, kLongestReach_px)) + 1;
  }
}

// More than one sample where a neighbour shows another surface, where the picture moves, and where
// the streak of something near that moves may reach.
Renderer::Impl::Plan Renderer::Impl::PlanFor(const Exposing& e, std::size_t number) const {
  const PixelRay& pixel = table.rays[number];
  const std::uint32_t key = e.first.KeyAt(pixel.u, pixel.v);
  Plan plan;
  double blur_px = e.blur_px.empty() ? 0.0 : static_cast<double>(e.blur_px[number].norm());
  constexpr std::array<std::array<int, 2>, 8> kWays{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};
  const int reach_px = e.first.Alone(pixel.u, pixel.v, e.streak_reach_px) ? 0 : e.streak_reach_px;
  for (int step = 1; step <= reach_px; ++step) {
    for (std::size_t way = 0; way < (step == 1 && e.streak_reach_px == 1 ? 4U : 8U); ++way) {
      const int u = pixel.u + step * kWays[way][0];
      const int v = pixel.v + step * kWays[way][1];
      const std::uint32_t other_key = e.first.KeyAt(u, v);
      if (other_key == key || other_key == FirstLook::kNothing) continue;
      if (step == 1 && way < 4) {
        plan.samples = settings.samples;
        plan.mixed = true;
      }
      if (e.blur_px.empty()) continue;
      const float other_px = e.blur_px[static_cast<std::size_t>(table.RayAt(u, v))].norm();
      if (other_px / 2 + 1 >= static_cast<float>(step)) {
        blur_px = std::max(blur_px, static_cast<double>(other_px));
        plan.mixed = true;
      } else if (blur_px / 2 + 1 >= static_cast<double>(step)) {
        plan.mixed = true;
      }
    }
  }
  if (blur_px > settings.still_px) {
    const int wanted = static_cast<int>(std::min(1.5 * blur_px, 64.0)) + 2;
    plan.samples = std::max(plan.samples, std::min(wanted | 1, settings.max_blur_samples));
  }
  return plan;
}

// One surface alone, drawn along its motion: the mean of the first look along the streak.
Eigen::Array3f Renderer::Impl::Smeared(const Exposing& e, std::size_t number, int samples) const {
  const PixelRay& pixel = table.rays[number];
  const std::uint32_t key = e.first.KeyAt(pixel.u, pixel.v);
  const Eigen::Array3f own = e.first.LightAt(pixel.u, pixel.v);
  const Eigen::Vector2f middle(pixel.u, pixel.v);
  Eigen::Array3f sum = own;
  for (int i = 1; i <= samples / 2; ++i) {
    const Eigen::Vector2f off =
        static_cast<float>(i) / static_cast<float>(samples) * e.blur_px[number];
    for (const float side : {1.0F, -1.0F}) {
      Eigen::Array3f light = own;
      e.first.LightBetween(middle + side * off, key, light);
      sum += light;
    }
  }
  return sum / static_cast<float>(samples);
}

// Whether the first look knows the light of what a sample met: it was seen at mid-exposure, in this
// pixel or near it.
bool Renderer::Impl::SeenBefore(const Exposing& e, const Sample& sample, const Sight& sight,
                                Eigen::Array3f& light) const {
  const PixelRay& pixel = table.rays[sample.number];
  Eigen::Vector2f place = Eigen::Vector2f(pixel.u, pixel.v) + sample.off_px;
  if (!e.blur_px.empty() && sight.hit.object != kRobotBodyObject) {
    const PixelTangents& tangents = table.tangents[sample.number];
    const Eigen::Vector3f ray = pixel.direction_camera.cast<float>();
    const Eigen::Vector3f to =
        (ray + tangents.along_u * sample.off_px.x() + tangents.along_v * sample.off_px.y())
            .normalized();
    const auto range_m = static_cast<float>(sight.hit.range_m);
    const Eigen::Vector2f shift = tangents.PixelsTo(sample.pose->SeenFromMiddle(to, range_m) - to);
    if (!(shift.squaredNorm() < kMostBlur_px * kMostBlur_px)) return false;
    place += shift;
  }
  return e.first.LightBetween(place, sight.surface_key, light);
}

void Renderer::Impl::Refine(Exposing& e, std::size_t first, std::size_t last) const {
  PacketTracer::Rays rays;
  PacketTracer::Sights sights;
  PacketTracer::Lights light;
  LitScene::Memory memory;
  std::array<Sample, kPacketRays> looks;
  int count = 0;
  const auto flush = [&] {
    tracer.Trace(rays, count, e.moment, sights);
    std::uint32_t unknown = 0;
    for (int lane = 0; lane < count; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      if (!SeenBefore(e, looks[l], sights[l], light[l])) unknown |= 1U << lane;
    }
    tracer.Shade(sights, unknown, e.moment, memory, light);
    for (int lane = 0; lane < count; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      e.light[looks[l].number] += light[l];
    }
    count = 0;
  };
  std::array<int, kChunk> samples;
  for (std::size_t number = first; number < last; ++number) {
    const PixelRay& pixel = table.rays[number];
    const Plan plan = PlanFor(e, number);
    samples[number - first] = 1;
    if (!plan.mixed && plan.samples > 1) {
      e.light[number] = Smeared(e, number, plan.samples);
      continue;
    }
    e.light[number] = e.first.LightAt(pixel.u, pixel.v);
    const int pairs = plan.samples / 2;
    samples[number - first] = 2 * pairs + 1;
    const PixelTangents& tangents = table.tangents[number];
    const std::uint32_t hash = HashCell(pixel.u, pixel.v, 77U);
    for (int i = 1; i <= pairs; ++i) {
      const Eigen::Vector2d place = PlaceInPixel(i, pairs, hash);
      const Eigen::Vector3d aside = (tangents.along_u * static_cast<float>(place.x()) +
                                     tangents.along_v * static_cast<float>(place.y()))
                                        .cast<double>();
      const int instant = ShutterPoses::InstantOf(i, pairs);
      for (const int side : {1, -1}) {
        const auto l = static_cast<std::size_t>(count);
        looks[l] = {number, (side * place).cast<float>(), &e.poses.At(pixel.v, side * instant)};
        rays[l] = {(pixel.direction_camera + side * aside).normalized(), looks[l].pose,
                   pixel.pixel_rad, may_meet_body[number] != 0};
        if (++count == kPacketRays) flush();
      }
    }
  }
  if (count > 0) flush();
  for (std::size_t number = first; number < last; ++number) {
    e.light[number] *= 1.0F / static_cast<float>(samples[number - first]);
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
      expose(gain * e.light[number], IndexOf(table.rays[number]));
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
      frame,
      FirstLook(frame.width_px, frame.height_px),
      std::vector<Eigen::Array3f>(rays),
      std::vector<double>((rays + kChunk - 1) / kChunk),
      {},
      1};
  impl_->InChunks(rays, [&](std::size_t, std::size_t first, std::size_t last) {
    impl_->TraceCentres(e, first, last);
  });
  impl_->SumUpBlocks(e);
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
