#include <array>
#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

constexpr double kSlab_m = 0.16;

/// Axes of a rectangle's roof: x along the ridge (the longer side), origin in the middle at the
/// walls' top.
struct RoofFrame {
  Frame frame;
  double half_ridge_m;  ///< half the length along the ridge
  double half_span_m;
};

RoofFrame FrameOf(const std::vector<Vector2d>& corners, double height_m) {
  const Vector2d middle = (corners[0] + corners[2]) / 2.0;
  const Vector2d first = corners[1] - corners[0];
  const Vector2d second = corners[2] - corners[1];
  const bool first_longer = first.norm() >= second.norm();
  const Vector2d ridge = first_longer ? first : second;
  return {Shift(middle.x(), middle.y(), height_m) * TurnZ(std::atan2(ridge.y(), ridge.x())),
          ridge.norm() / 2.0, (first_longer ? second : first).norm() / 2.0};
}

void Gutters(Workshop& shop, const RoofFrame& roof, double out_m, double z_m, double half_m) {
  const std::uint32_t gutter = shop.materials.Paint({0.30, 0.29, 0.27}, 0.02F);
  for (const double side : {-1.0, 1.0})
    shop.solid.Tube(gutter, roof.frame * Vector3d(-half_m, side * out_m, z_m),
                    roof.frame * Vector3d(half_m, side * out_m, z_m), 0.06, 0.06, 10);
}

void Flat(Workshop& shop, const BuildingConfig& b, const std::vector<Vector2d>& corners) {
  const std::uint32_t roof = shop.materials.Add(b.roof.surface, shop.dice.Next());
  const std::uint32_t coping = shop.materials.Paint({0.38, 0.38, 0.37}, 0.03F);
  SolidBuilder& s = shop.solid;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d along = corners[(i + 1) % corners.size()] - corners[i];
    const Frame side =
        Shift(corners[i].x(), corners[i].y(), b.height_m) * TurnZ(std::atan2(along.y(), along.x()));
    const double l = along.norm(), e = b.roof.eaves_m, top = std::max(b.roof.rise_m, kSlab_m);
    s.BoxBetween(roof, side, {-e, -e, 0}, {l + e, 0.25, kSlab_m});  // slab's edge and eaves
    if (b.roof.rise_m > kSlab_m) {
      s.BoxBetween(roof, side, {-0.02, -0.02, kSlab_m}, {l + 0.02, 0.16, top});
      s.BoxBetween(coping, side, {-0.07, -0.07, top}, {l + 0.07, 0.21, top + 0.05});
    }
  }
  s.Prism(roof, roof, Shift(0, 0, b.height_m), corners, 0.0, kSlab_m);
}

void Gable(Workshop& shop, const BuildingConfig& b, const std::vector<Vector2d>& corners,
           std::uint32_t wall) {
  SolidBuilder& s = shop.solid;
  const RoofFrame r = FrameOf(corners, b.height_m);
  const double a = r.half_ridge_m, w = r.half_span_m, rise = b.roof.rise_m, e = b.roof.eaves_m;
  // The gables close the walls' body; its own slopes are hidden under the slab.
  const std::vector<Vector2d> attic{{-w, 0.0}, {w, 0.0}, {0.0, rise}};
  // Outline axes: x across, y up, z along the ridge.
  const Frame across = r.frame * TurnZ(core::kPi / 2.0) * TurnX(core::kPi / 2.0);
  s.Prism(wall, wall, across, attic, -a, a);
  const double fall = rise / w, low = -e * fall, thick = kSlab_m * std::hypot(1.0, fall);
  const std::vector<Vector2d> slab{{-w - e, low},       {0.0, rise},
                                   {w + e, low},        {w + e, low + thick},
                                   {0.0, rise + thick}, {-w - e, low + thick}};
  const std::uint32_t roof = shop.materials.Add(b.roof.surface, shop.dice.Next());
  const double gable_e = e * 0.7;
  s.Prism(roof, roof, across, slab, -a - gable_e, a + gable_e);
  s.BoxBetween(roof, r.frame, {-a - gable_e - 0.02, -0.14, rise + thick - 0.06},
               {a + gable_e + 0.02, 0.14, rise + thick + 0.09});  // ridge tiles
  if (b.fittings) Gutters(shop, r, w + e + 0.03, low + 0.02, a + gable_e);
}

void Hip(Workshop& shop, const BuildingConfig& b, const std::vector<Vector2d>& corners) {
  SolidBuilder& s = shop.solid;
  const RoofFrame r = FrameOf(corners, b.height_m);
  const std::uint32_t roof = shop.materials.Add(b.roof.surface, shop.dice.Next());
  const std::uint32_t soffit = shop.materials.Paint({0.42, 0.40, 0.36}, 0.0F);
  const double e = b.roof.eaves_m, x = r.half_ridge_m + e, y = r.half_span_m + e;
  const double ridge = std::max(0.15, x - y), top = b.roof.rise_m;
  const auto at = [&r](double px, double py, double pz) -> Vector3d {
    return r.frame * Vector3d(px, py, pz);
  };
  s.Quad(soffit, at(-x, y, 0), at(x, y, 0), at(x, -y, 0), at(-x, -y, 0));
  const double f = kSlab_m;
  const std::array<Vector2d, 4> c{Vector2d(-x, -y), Vector2d(x, -y), Vector2d(x, y),
                                  Vector2d(-x, y)};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d &p = c[i], &q = c[(i + 1) % 4];
    s.Quad(soffit, at(p.x(), p.y(), 0), at(q.x(), q.y(), 0), at(q.x(), q.y(), f),
           at(p.x(), p.y(), f));
  }
  s.Quad(roof, at(-x, -y, f), at(x, -y, f), at(ridge, 0, top), at(-ridge, 0, top));
  s.Quad(roof, at(x, y, f), at(-x, y, f), at(-ridge, 0, top), at(ridge, 0, top));
  s.Triangle(roof, at(x, -y, f), at(x, y, f), at(ridge, 0, top));
  s.Triangle(roof, at(-x, y, f), at(-x, -y, f), at(-ridge, 0, top));
  s.BoxBetween(roof, r.frame, {-ridge - 0.1, -0.13, top - 0.08}, {ridge + 0.1, 0.13, top + 0.08});
  for (const Vector2d& p : c) {  // hip tiles
    const double sx = p.x() > 0 ? ridge : -ridge;
    s.Tube(roof, at(p.x(), p.y(), f + 0.02), at(sx, 0, top + 0.02), 0.09, 0.09, 8);
  }
  if (b.fittings) Gutters(shop, r, y + 0.04, 0.04, x);
}

}  // namespace

void BuildRoof(Workshop& shop, const BuildingConfig& building, std::uint32_t wall,
               const std::vector<Vector2d>& corners) {
  switch (building.roof.type) {
    case RoofType::kFlat:
      return Flat(shop, building, corners);
    case RoofType::kGable:
      return Gable(shop, building, corners, wall);
    case RoofType::kHip:
      return Hip(shop, building, corners);
  }
}

}  // namespace kawara::sim
