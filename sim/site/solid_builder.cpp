#include "sim/site/solid_builder.hpp"

#include <algorithm>
#include <cmath>

#include "sim/site/polygon.hpp"

namespace kawara::sim {
namespace {

constexpr double kFlat_m2 = 1e-8;

struct SurfaceAxes {
  Vector3d u;
  Vector3d v;
};

/// u level and v up the face; on level faces the object's x and y.
SurfaceAxes AxesOf(const Vector3d& normal) {
  constexpr double kLevel = 0.99;
  if (std::abs(normal.z()) > kLevel) return {Vector3d::UnitX(), Vector3d::UnitY()};
  const Vector3d u = Vector3d::UnitZ().cross(normal).normalized();
  return {u, normal.cross(u)};
}

/// By Newell's rule, so that any corner may lie flat.
Vector3d NormalOf(std::span<const Vector3d> corners) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i)
    sum += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
  return sum.norm() > 0 ? Vector3d(sum.normalized()) : Vector3d::UnitZ();
}

}  // namespace

Frame Shift(double x_m, double y_m, double z_m) {
  return Frame(Eigen::Translation3d(x_m, y_m, z_m));
}
Frame TurnZ(double angle_rad) { return Frame(Eigen::AngleAxisd(angle_rad, Vector3d::UnitZ())); }
Frame TurnX(double angle_rad) { return Frame(Eigen::AngleAxisd(angle_rad, Vector3d::UnitX())); }
Frame TurnY(double angle_rad) { return Frame(Eigen::AngleAxisd(angle_rad, Vector3d::UnitY())); }

Frame StandingFrame(double east_m, double north_m, double up_m, double heading_rad) {
  return Shift(east_m, north_m, up_m) * TurnZ(core::kPi / 2.0 - heading_rad);
}

Mesh& SolidBuilder::MeshOf(std::uint32_t material) {
  Mesh& mesh = meshes_[material];
  mesh.material = material;
  mesh.object = object_;
  return mesh;
}

void SolidBuilder::TriangleUv(std::uint32_t material, const std::array<Vector3d, 3>& corners,
                              const std::array<Vector2d, 3>& uv_m) {
  if ((corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2.0 < kFlat_m2) return;
  Mesh& mesh = MeshOf(material);
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (std::size_t i = 0; i < 3; ++i) {
    mesh.vertices_m.emplace_back((enu_from_local_ * corners[i]).cast<float>());
    mesh.uv_m.emplace_back(uv_m[i].cast<float>());
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
}

void SolidBuilder::Face(std::uint32_t material, std::span<const Vector3d> corners) {
  if (corners.size() < 3) return;
  const SurfaceAxes axes = AxesOf(NormalOf(corners));
  const auto uv = [&axes](const Vector3d& p) { return Vector2d(p.dot(axes.u), p.dot(axes.v)); };
  Mesh& mesh = MeshOf(material);
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const Vector3d& corner : corners) {
    mesh.vertices_m.emplace_back((enu_from_local_ * corner).cast<float>());
    mesh.uv_m.emplace_back(uv(corner).cast<float>());
  }
  for (std::uint32_t i = 2; i < corners.size(); ++i) {
    if ((corners[i - 1] - corners[0]).cross(corners[i] - corners[0]).norm() / 2.0 >= kFlat_m2)
      mesh.triangles.push_back({first, first + i - 1, first + i});
  }
}

void SolidBuilder::Quad(std::uint32_t material, const Vector3d& a, const Vector3d& b,
                        const Vector3d& c, const Vector3d& d) {
  Face(material, std::array{a, b, c, d});
}

void SolidBuilder::Triangle(std::uint32_t material, const Vector3d& a, const Vector3d& b,
                            const Vector3d& c) {
  Face(material, std::array{a, b, c});
}

void SolidBuilder::Hexahedron(std::uint32_t material, const std::array<Vector3d, 8>& c) {
  constexpr std::array<std::array<std::size_t, 4>, 6> kFaces{
      {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  for (const auto& f : kFaces) Quad(material, c[f[0]], c[f[1]], c[f[2]], c[f[3]]);
}

void SolidBuilder::Box(std::uint32_t material, const Frame& at, const Vector3d& size_m) {
  const double x = size_m.x() / 2.0;
  const double y = size_m.y() / 2.0;
  const double z = size_m.z();
  std::array<Vector3d, 8> corners{Vector3d(-x, -y, 0), Vector3d(x, -y, 0),  Vector3d(x, y, 0),
                                  Vector3d(-x, y, 0),  Vector3d(-x, -y, z), Vector3d(x, -y, z),
                                  Vector3d(x, y, z),   Vector3d(-x, y, z)};
  for (Vector3d& corner : corners) corner = at * corner;
  Hexahedron(material, corners);
}

void SolidBuilder::BoxBetween(std::uint32_t material, const Frame& at, const Vector3d& low,
                              const Vector3d& high) {
  const Vector3d foot((low.x() + high.x()) / 2.0, (low.y() + high.y()) / 2.0, low.z());
  Box(material, at * Frame(Eigen::Translation3d(foot)), high - low);
}

void SolidBuilder::Prism(std::uint32_t side, std::uint32_t cap, const Frame& at,
                         const std::vector<Vector2d>& outline, double z0_m, double z1_m) {
  const auto point = [&at](const Vector2d& p, double z) -> Vector3d {
    return at * Vector3d(p.x(), p.y(), z);
  };
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& p = outline[i];
    const Vector2d& q = outline[(i + 1) % outline.size()];
    Quad(side, point(p, z0_m), point(q, z0_m), point(q, z1_m), point(p, z1_m));
  }
  for (const auto& t : Triangulate(outline)) {
    Triangle(cap, point(outline[t[0]], z1_m), point(outline[t[1]], z1_m),
             point(outline[t[2]], z1_m));
    Triangle(cap, point(outline[t[2]], z0_m), point(outline[t[1]], z0_m),
             point(outline[t[0]], z0_m));
  }
}

void SolidBuilder::ChamferedPrism(std::uint32_t material, const Frame& at,
                                  const std::vector<Vector2d>& outline, double z0_m, double z1_m,
                                  double chamfer_m) {
  const std::size_t n = outline.size();
  std::vector<Vector2d> inner;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d before = (outline[i] - outline[(i + n - 1) % n]).normalized();
    const Vector2d after = (outline[(i + 1) % n] - outline[i]).normalized();
    const Vector2d in_before(-before.y(), before.x()), in_after(-after.y(), after.x());
    constexpr double kSharp = 0.4;  // no corner moves further than some chamfers
    inner.push_back(outline[i] + (in_before + in_after) *
                                     (chamfer_m / std::max(kSharp, 1.0 + in_before.dot(in_after))));
  }
  const auto point = [&at](const Vector2d& p, double z) -> Vector3d {
    return at * Vector3d(p.x(), p.y(), z);
  };
  const auto band = [&](const std::vector<Vector2d>& low, double low_z,
                        const std::vector<Vector2d>& high, double high_z) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = (i + 1) % n;
      Quad(material, point(low[i], low_z), point(low[k], low_z), point(high[k], high_z),
           point(high[i], high_z));
    }
  };
  band(inner, z0_m, outline, z0_m + chamfer_m);
  band(outline, z0_m + chamfer_m, outline, z1_m - chamfer_m);
  band(outline, z1_m - chamfer_m, inner, z1_m);
  for (const auto& t : Triangulate(inner)) {
    Triangle(material, point(inner[t[0]], z1_m), point(inner[t[1]], z1_m),
             point(inner[t[2]], z1_m));
    Triangle(material, point(inner[t[2]], z0_m), point(inner[t[1]], z0_m),
             point(inner[t[0]], z0_m));
  }
}

void SolidBuilder::Loft(std::uint32_t material, std::span<const Ring> rings, int sides) {
  const auto corner = [&](const Ring& ring, int i) -> Vector3d {
    const double angle = 2.0 * core::kPi * (i % sides) / sides;
    return ring.centre + ring.u * std::cos(angle) + ring.v * std::sin(angle);
  };
  double along = 0.0;
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    const Ring& low = rings[r];
    const Ring& high = rings[r + 1];
    const double rise = std::hypot((high.centre - low.centre).norm(), high.u.norm() - low.u.norm());
    const double around =
        core::kPi * (std::max(low.u.norm() + low.v.norm(), high.u.norm() + high.v.norm())) / sides;
    for (int i = 0; i < sides; ++i) {
      const Vector3d a = corner(low, i), b = corner(low, i + 1);
      const Vector3d c = corner(high, i + 1), d = corner(high, i);
      const Vector2d uv_a(around * i, along), uv_b(around * (i + 1), along);
      const Vector2d uv_c(around * (i + 1), along + rise), uv_d(around * i, along + rise);
      TriangleUv(material, {a, b, c}, {uv_a, uv_b, uv_c});
      TriangleUv(material, {a, c, d}, {uv_a, uv_c, uv_d});
    }
    along += rise;
  }
  std::vector<Vector3d> floor, top;
  for (int i = 0; i < sides; ++i) {
    floor.push_back(corner(rings.front(), sides - 1 - i));
    top.push_back(corner(rings.back(), i));
  }
  Face(material, floor);
  Face(material, top);
}

void SolidBuilder::Tube(std::uint32_t material, const Vector3d& p, const Vector3d& q,
                        double radius_p_m, double radius_q_m, int sides) {
  const Vector3d way = (q - p).normalized();
  const Vector3d u = way.unitOrthogonal();
  const Vector3d v = way.cross(u);
  const std::array rings{Ring{p, u * radius_p_m, v * radius_p_m},
                         Ring{q, u * radius_q_m, v * radius_q_m}};
  Loft(material, rings, sides);
}

void SolidBuilder::Plate(std::uint32_t material, const std::array<Vector3d, 4>& quad, double u0,
                         double u1, double v0, double v1, double proud_m) {
  const Vector3d out = NormalOf(quad);
  const auto point = [&](double u, double v) -> Vector3d {
    return (1 - v) * ((1 - u) * quad[0] + u * quad[1]) + v * ((1 - u) * quad[3] + u * quad[2]);
  };
  const std::array base{point(u0, v0), point(u1, v0), point(u1, v1), point(u0, v1)};
  std::array<Vector3d, 8> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    corners[i] = base[i] - out * proud_m;
    corners[i + 4] = base[i] + out * proud_m;
  }
  Hexahedron(material, corners);
}

void SolidBuilder::AppendTo(Scene& scene) const {
  for (const auto& [material, mesh] : meshes_) {
    if (!mesh.triangles.empty()) scene.meshes.push_back(mesh);
  }
}

}  // namespace kawara::sim
