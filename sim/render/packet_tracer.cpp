#include "sim/render/packet_tracer.hpp"

#include <bit>
#include <cmath>

#include "core/check.hpp"
#include "sim/render/noise2.hpp"

namespace kawara::sim {
namespace {

/// A body casts its shadow at most this many times its own size far; beyond, the sun is too low to
/// matter for a picture.
constexpr double kShadowReach = 6.0;

std::uint32_t SurfaceKey(const RayHit& hit, bool sunlit) {
  const auto part = [&](float x) { return FloorInt(8.0F * x + 0.5F); };
  return HashCell(part(hit.normal_enu.x()),
                  part(hit.normal_enu.y()) * 64 + part(hit.normal_enu.z()),
                  hit.object * 2U + (sunlit ? 1U : 0U) + hit.material * 0x10001U) |
         1U;
}

}  // namespace

PacketTracer::PacketTracer(std::shared_ptr<const LitScene> scene, const RobotBody& body)
    : scene_(std::move(scene)) {
  if (body.empty()) return;
  Scene alone;
  alone.materials = body.materials;
  alone.meshes = body.meshes;
  core::Expected<RayScene> made = RayScene::Create(alone);
  CORE_CHECK(made.has_value());  // a body is made by the program, not read
  body_.emplace(std::move(*made));
  const float size_m = std::max(body_->low_enu_m().norm(), body_->high_enu_m().norm());
  body_reach_m_ = kShadowReach * static_cast<double>(size_m);
}

bool PacketTracer::MeetsBody(const Eigen::Vector3d& direction_camera) const {
  return body_ && body_->Cast(Eigen::Vector3d::Zero(), direction_camera, {}).hit();
}

void PacketTracer::FindSurfaces(const Rays& rays, int count, const RayScene::Moment& moment,
                                Sights& sights) const {
  RayPacket to_world;
  RayPacket to_body;
  for (int lane = 0; lane < count; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    sights[l].direction_enu = rays[l].pose->R_enu_camera * rays[l].direction_camera;
    to_world.Set(lane, rays[l].pose->origin_enu_m, sights[l].direction_enu);
    if (body_ && rays[l].may_meet_body) {
      to_body.Set(lane, Eigen::Vector3d::Zero(), rays[l].direction_camera);
    }
  }
  PacketHits body_hits;
  body_hits.triangle.fill(kNoTriangle);
  if (to_body.lanes != 0) body_->Intersect(to_body, {}, body_hits);
  PacketHits hits;
  scene_->rays().Intersect(to_world, moment, hits);
  for (int lane = 0; lane < count; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    Sight& m = sights[l];
    const ShutterPoses::Pose& pose = *rays[l].pose;
    m.hit = {};
    m.material = nullptr;
    m.pixel_rad = rays[l].pixel_rad;
    if (hits.triangle[l] != kNoTriangle) {
      m.hit = scene_->rays().Resolve(hits.triangle[l], hits.range_m[l], pose.origin_enu_m,
                                     m.direction_enu);
      m.material = &scene_->rays().materials()[m.hit.material];
    }
    if (body_hits.triangle[l] != kNoTriangle) {
      RayHit on_body = body_->Resolve(body_hits.triangle[l], body_hits.range_m[l],
                                      Eigen::Vector3d::Zero(), rays[l].direction_camera);
      if (on_body.range_m < m.hit.range_m) {
        const Eigen::Matrix3f R = pose.R_enu_camera.cast<float>();
        on_body.normal_enu = R * on_body.normal_enu;
        on_body.gradient_u = R * on_body.gradient_u;
        on_body.gradient_v = R * on_body.gradient_v;
        m.hit = on_body;
        m.material = &body_->materials()[on_body.material];
      }
    }
    if (m.hit.hit()) m.place_enu_m = pose.origin_enu_m + m.hit.range_m * m.direction_enu;
  }
}

void PacketTracer::FindSunlight(const Rays& rays, int count, const RayScene::Moment& moment,
                                Sights& sights) const {
  const Eigen::Vector3d to_sun = scene_->sky().to_sun_enu().cast<double>();
  RayPacket to_world;
  RayPacket to_body;
  for (int lane = 0; lane < count; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    Sight& m = sights[l];
    m.wants_sun = m.hit.hit() && scene_->WantsSun(*m.material, m.hit, m.place_enu_m,
                                                  m.direction_enu.cast<float>(), m.sun_start_enu_m);
    if (!m.wants_sun) continue;
    to_world.Set(lane, m.sun_start_enu_m, to_sun);
    if (body_ && m.hit.range_m < body_reach_m_) {
      const ShutterPoses::Pose& pose = *rays[l].pose;
      to_body.Set(lane, pose.R_enu_camera.transpose() * (m.sun_start_enu_m - pose.origin_enu_m),
                  pose.R_enu_camera.transpose() * to_sun);
    }
  }
  const std::uint32_t shaded = scene_->rays().Blocked(to_world, moment);
  to_body.lanes &= ~shaded;
  const std::uint32_t shaded_by_body = to_body.lanes != 0 ? body_->Blocked(to_body, {}) : 0;
  for (int lane = 0; lane < count; ++lane) {
    Sight& m = sights[static_cast<std::size_t>(lane)];
    m.sunlit = m.wants_sun && ((shaded | shaded_by_body) >> lane & 1U) == 0;
  }
}

void PacketTracer::Trace(const Rays& rays, int count, const RayScene::Moment& moment,
                         Sights& sights) const {
  FindSurfaces(rays, count, moment, sights);
  FindSunlight(rays, count, moment, sights);
  for (int lane = 0; lane < count; ++lane) {
    Sight& sight = sights[static_cast<std::size_t>(lane)];
    sight.surface_key = sight.hit.hit() ? SurfaceKey(sight.hit, sight.sunlit) : Sight::kSky;
  }
}

void PacketTracer::Shade(const Sights& sights, std::uint32_t lanes, const RayScene::Moment& moment,
                         LitScene::Memory& memory, Lights& light) const {
  std::array<SurfaceView, kPacketRays> views;
  Lights shaded;
  std::array<std::size_t, kPacketRays> of{};
  std::size_t count = 0;
  for (std::uint32_t left = lanes; left != 0; left &= left - 1U) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    const Sight& sight = sights[lane];
    if (!sight.hit.hit()) {
      light[lane] = scene_->sky().Radiance(sight.direction_enu.cast<float>());
      continue;
    }
    views[count] = {sight.material,
                    &sight.hit,
                    sight.place_enu_m,
                    sight.direction_enu.cast<float>(),
                    sight.pixel_rad,
                    sight.sunlit,
                    moment};
    of[count++] = lane;
  }
  if (count == 0) return;
  scene_->Radiance({views.data(), count}, memory, shaded);
  for (std::size_t i = 0; i < count; ++i) light[of[i]] = shaded[i];
}

}  // namespace kawara::sim
