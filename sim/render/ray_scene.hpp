#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "core/expected.hpp"
#include "sim/site/scene.hpp"

namespace kawara::sim {

constexpr int kPacketRays = 16;

/// Sixteen rays at once, one array a coordinate; directions of unit length. Bit i of `lanes`: ray i
/// is wanted.
struct alignas(64) RayPacket {
  std::array<float, kPacketRays> origin_x{}, origin_y{}, origin_z{};
  std::array<float, kPacketRays> direction_x{}, direction_y{}, direction_z{};
  std::array<float, kPacketRays> max_range_m{};
  std::uint32_t lanes = 0;

  void Set(int lane, const Eigen::Vector3d& origin_enu_m, const Eigen::Vector3d& direction_enu,
           float lane_max_range_m = std::numeric_limits<float>::infinity());
};

/// Nearest triangle a ray.
struct alignas(64) PacketHits {
  std::array<std::uint32_t, kPacketRays> triangle{};
  std::array<float, kPacketRays> range_m{};
};
constexpr std::uint32_t kNoTriangle = 0xFFFFFFFFU;

/// What a ray met.
struct RayHit {
  double range_m = std::numeric_limits<double>::infinity();
  std::uint32_t object = 0;  ///< SceneObject::id; 0: the sky
  std::uint32_t material = 0;
  Eigen::Vector3f normal_enu = Eigen::Vector3f::Zero();  ///< unit, to the outside of the mesh
  Eigen::Vector2f uv_m = Eigen::Vector2f::Zero();
  /// Change of u and v a metre along the surface, in ENU; zero if the mesh has no usable uv.
  Eigen::Vector3f gradient_u = Eigen::Vector3f::Zero(), gradient_v = Eigen::Vector3f::Zero();
  bool hit() const { return object != 0; }
};

/// A Scene for casting rays (Embree). Objects with a time of existence are there for rays of that
/// time only: begin_s <= t < end_s.
///
/// Embree decides in single floats WHICH triangle is met; where is then computed in doubles from
/// the triangle's plane, so that ranges are exact to the rounding of the scene's own vertices also
/// for ground seen at a grazing angle. Triangles without area are left out.
///
/// Immutable after Create; any number of threads cast at once. The same rays in the same packets
/// give the same bits on the same kind of processor (on others a ray that runs into an edge may
/// name the other of its triangles).
class RayScene {
 public:
  /// kInvalidArgument: a mesh whose indices lead nowhere, coordinates that are not finite, object
  /// 0.
  static core::Expected<RayScene> Create(const Scene& scene);

  /// Which objects exist; from MomentAt, for all rays of one instant.
  struct Moment {
    std::uint32_t stage = 0;  ///< which of the Embree scenes (one for 32 changes)
    std::uint32_t mask = 1;
  };
  Moment MomentAt(double time_s) const;

  RayHit Cast(const Eigen::Vector3d& origin_enu_m, const Eigen::Vector3d& direction_enu,
              const Moment& moment) const;
  /// Anything between the origin and `max_range_m` along the direction.
  bool Blocked(const Eigen::Vector3d& origin_enu_m, const Eigen::Vector3d& direction_enu,
               double max_range_m, const Moment& moment) const;

  void Intersect(const RayPacket& rays, const Moment& moment, PacketHits& hits) const;
  /// Bit i: ray i is blocked.
  std::uint32_t Blocked(const RayPacket& rays, const Moment& moment) const;
  /// Exact hit on a triangle that Intersect() named. `direction_enu` of unit length.
  RayHit Resolve(std::uint32_t triangle, float range_m, const Eigen::Vector3d& origin_enu_m,
                 const Eigen::Vector3d& direction_enu) const;

  const std::vector<Material>& materials() const;
  const Sun& sun() const;
  std::size_t triangle_count() const;
  std::array<Eigen::Vector3f, 3> Corners(std::size_t triangle) const;
  /// Corners of the box around everything; both zero for an empty scene.
  const Eigen::Vector3f& low_enu_m() const;
  const Eigen::Vector3f& high_enu_m() const;

 private:
  struct Impl;
  explicit RayScene(std::shared_ptr<const Impl> impl);
  std::shared_ptr<const Impl> impl_;
};

}  // namespace kawara::sim
