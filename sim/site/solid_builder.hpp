#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "sim/site/scene.hpp"

namespace kawara::sim {

using Eigen::Vector2d;
using Eigen::Vector3d;
/// Takes points of a part's own axes to those it is built into [m].
using Frame = Eigen::Isometry3d;

Frame Shift(double x_m, double y_m, double z_m);
Frame TurnZ(double angle_rad);
Frame TurnX(double angle_rad);
Frame TurnY(double angle_rad);
/// Local axes of a thing on the ground: x along the heading, y to its left, z up.
Frame StandingFrame(double east_m, double north_m, double up_m, double heading_rad);

/// One ring of a loft, in a plane of its own.
struct Ring {
  Vector3d centre = Vector3d::Zero();
  Vector3d u = Vector3d::UnitX();  ///< half axes: the ring runs from u towards v,
  Vector3d v = Vector3d::UnitY();  ///< counter-clockwise seen against the way of the loft
};

/// Triangles of one object while it is made, a mesh for each material, in local axes given by
/// frames; comes out in the site's ENU. Faces are given counter-clockwise seen from outside;
/// texture coordinates are metres along the surface: on upright faces (along, up), so that courses
/// and joints run level. Triangles that are flat beyond use (under 1e-8 m^2) are left out.
/// One thread.
class SolidBuilder {
 public:
  SolidBuilder(const Frame& enu_from_local, std::uint32_t object)
      : enu_from_local_(enu_from_local), object_(object) {}

  /// Plane, convex; corners in the object's axes.
  void Face(std::uint32_t material, std::span<const Vector3d> corners);
  void Quad(std::uint32_t material, const Vector3d& a, const Vector3d& b, const Vector3d& c,
            const Vector3d& d);
  void Triangle(std::uint32_t material, const Vector3d& a, const Vector3d& b, const Vector3d& c);
  /// With texture coordinates of the caller's.
  void TriangleUv(std::uint32_t material, const std::array<Vector3d, 3>& corners,
                  const std::array<Vector2d, 3>& uv_m);

  /// Centred on the frame's origin in x and y, standing on it.
  void Box(std::uint32_t material, const Frame& at, const Vector3d& size_m);
  /// Along the frame's axes from corner to corner.
  void BoxBetween(std::uint32_t material, const Frame& at, const Vector3d& low,
                  const Vector3d& high);
  /// Closed hull of 8 corners: 0-3 the floor and 4-7 the top above it, each counter-clockwise from
  /// above. Faces may be a little out of plane; they are split in two.
  void Hexahedron(std::uint32_t material, const std::array<Vector3d, 8>& corners);
  /// The plane outline (counter-clockwise from +z of the frame) drawn up from z0 to z1.
  void Prism(std::uint32_t side, std::uint32_t cap, const Frame& at,
             const std::vector<Vector2d>& outline, double z0_m, double z1_m);
  /// A prism of one material whose long edges are cut off by `chamfer_m`: what pressed metal looks
  /// like. The outline's corners must be further apart than that.
  void ChamferedPrism(std::uint32_t material, const Frame& at, const std::vector<Vector2d>& outline,
                      double z0_m, double z1_m, double chamfer_m);
  /// Skin over rings of `sides` corners, closed by flat caps.
  void Loft(std::uint32_t material, std::span<const Ring> rings, int sides);
  /// Cone frustum from p to q.
  void Tube(std::uint32_t material, const Vector3d& p, const Vector3d& q, double radius_p_m,
            double radius_q_m, int sides);
  /// A thin plate on the quad a b c d (counter-clockwise from outside; u from a to b, v from a to
  /// d), covering u0..u1, v0..v1 of it and standing out by `proud_m`.
  void Plate(std::uint32_t material, const std::array<Vector3d, 4>& quad, double u0, double u1,
             double v0, double v1, double proud_m);

  /// Adds what was made to the scene.
  void AppendTo(Scene& scene) const;
  bool empty() const { return meshes_.empty(); }

 private:
  Mesh& MeshOf(std::uint32_t material);

  Frame enu_from_local_;
  std::uint32_t object_;
  std::map<std::uint32_t, Mesh> meshes_;
};

}  // namespace kawara::sim
