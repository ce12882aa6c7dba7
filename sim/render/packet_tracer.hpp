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

/// What a ray met.
struct Sight {
  RayHit hit;  ///< normal and gradients in ENU, also the body's
  Eigen::Vector3d direction_enu;
  Eigen::Vector3d place_enu_m;
  Eigen::Vector3d sun_start_enu_m;
  const Material* material = nullptr;  ///< null: the sky
  float pixel_rad = 0.0F;
  bool wants_sun = false;
  bool sunlit = false;
  /// Differs where the surface, its facing or its sunlight differ; kSky: nothing was met.
  std::uint32_t surface_key = 0;

  static constexpr std::uint32_t kSky = 0;
};

/// Follows up to sixteen camera rays at once: the robot's own body first, then the scene, then from
/// both towards the sun. Immutable; any thread.
class PacketTracer {
 public:
  PacketTracer(std::shared_ptr<const LitScene> scene, const RobotBody& body);

  using Rays = std::array<CameraRay, kPacketRays>;
  using Sights = std::array<Sight, kPacketRays>;
  using Lights = std::array<Eigen::Array3f, kPacketRays>;
  /// What the first `count` rays meet.
  void Trace(const Rays& rays, int count, const RayScene::Moment& moment, Sights& sights) const;
  /// The light that comes from there, for those whose bit is set in `lanes`.
  void Shade(const Sights& sights, std::uint32_t lanes, const RayScene::Moment& moment,
             LitScene::Memory& memory, Lights& light) const;

  /// Whether a ray from the camera meets the body.
  bool MeetsBody(const Eigen::Vector3d& direction_camera) const;
  const LitScene& scene() const { return *scene_; }

 private:
  void FindSurfaces(const Rays& rays, int count, const RayScene::Moment& moment,
                    Sights& sights) const;
  void FindSunlight(const Rays& rays, int count, const RayScene::Moment& moment,
                    Sights& sights) const;

  std::shared_ptr<const LitScene> scene_;
  std::optional<RayScene> body_;
  double body_reach_m_ = 0.0;  ///< farther than this from the camera the body's shadow is not asked
};

}  // namespace kawara::sim
