#include "sim/render/packet_tracer.hpp"

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
                  hit.object * 2U + (sunlit ? 1U : 0U) + hit.material * 0x10001U);
}

}  // namespace

struct PacketTracer::Met {
  RayHit hit;
  Eigen::Vector3d direction_enu;
  Eigen::Vector3d place_enu_m;
  Eigen::Vector3d sun_start_enu_m;
  const Material* material = nullptr;
  bool wants_sun = false;
  bool sunlit = false;
};

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
                                std::array<Met, kPacketRays>& met) const {
  RayPacket to_world;
  RayPacket to_body;
  for (int lane = 0; lane < count; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    met[l].direction_enu = rays[l].pose->R_enu_camera * rays[l].direction_camera;
    to_world.Set(lane, rays[l].pose->origin_enu_m, met[l].direction_enu);
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
    Met& m = met[l];
    const ShutterPoses::Pose& pose = *rays[l].pose;
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
                                std::array<Met, kPacketRays>& met) const {
  const Eigen::Vector3d to_sun = scene_->sky().to_sun_enu().cast<double>();
  RayPacket to_world;
  RayPacket to_body;
  for (int lane = 0; lane < count; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    Met& m = met[l];
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
    Met& m = met[static_cast<std::size_t>(lane)];
    m.sunlit = m.wants_sun && ((shaded | shaded_by_body) >> lane & 1U) == 0;
  }
}

void PacketTracer::Trace(const Rays& rays, int count, const RayScene::Moment& moment,
                         Traced& traced) const {
  std::array<Met, kPacketRays> met;
  FindSurfaces(rays, count, moment, met);
  FindSunlight(rays, count, moment, met);
  for (int lane = 0; lane < count; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    const Met& m = met[l];
    TracedRay& out = traced[l];
    out.range_m = static_cast<float>(m.hit.range_m);
    out.object = m.hit.object;
    if (!m.hit.hit()) {
      out.light = scene_->sky().Radiance(m.direction_enu.cast<float>());
      out.surface_key = 0;
      continue;
    }
    out.light = scene_->Radiance({*m.material, m.hit, m.place_enu_m, m.direction_enu.cast<float>(),
                                  rays[l].pixel_rad, m.sunlit, moment});
    out.surface_key = SurfaceKey(m.hit, m.sunlit);
  }
}

}  // namespace kawara::sim
