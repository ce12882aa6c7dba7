#pragma once
#include <array>
#include <memory>
#include <optional>

#include "sim/render/lit_scene.hpp"
#include "sim/render/robot_body.hpp"
#include "sim/render/shutter.hpp"

namespace kawara::sim {

/// One ray of a camera to follow.
struct CameraRay {
  Eigen::Vector3d direction_camera = Eigen::Vector3d::UnitZ();
  const ShutterPoses::Pose* pose = nullptr;
  float pixel_rad = 0.0F;
  bool may_meet_body = false;
};

/// What it brought back.
struct TracedRay {
  Eigen::Array3f light = Eigen::Array3f::Zero();
  float range_m = 0.0F;
  std::uint32_t object = 0;
  std::uint32_t surface_key = 0;  ///< differs where the surface, its facing or its sunlight differ
};

/// Follows up to sixteen camera rays at once: the robot's own body first, then the scene, then from
/// both towards the sun. Immutable; any thread.
class PacketTracer {
 public:
  PacketTracer(std::shared_ptr<const LitScene> scene, const RobotBody& body);

  using Rays = std::array<CameraRay, kPacketRays>;
  using Traced = std::array<TracedRay, kPacketRays>;
  void Trace(const Rays& rays, int count, const RayScene::Moment& moment, Traced& traced) const;

  /// Whether a ray from the camera meets the body.
  bool MeetsBody(const Eigen::Vector3d& direction_camera) const;
  const LitScene& scene() const { return *scene_; }

 private:
  struct Met;
  void FindSurfaces(const Rays& rays, int count, const RayScene::Moment& moment,
                    std::array<Met, kPacketRays>& met) const;
  void FindSunlight(const Rays& rays, int count, const RayScene::Moment& moment,
                    std::array<Met, kPacketRays>& met) const;

  std::shared_ptr<const LitScene> scene_;
  std::optional<RayScene> body_;
  double body_reach_m_ = 0.0;  ///< farther than this from the camera the body's shadow is not asked
};

}  // namespace kawara::sim
