#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

/// One straight leg of a fence: x along it, z up; the ground falls evenly from one end to the
/// other.
class Leg {
 public:
  Leg(const Vector3d& from, const Vector3d& to)
      : frame_(StandingFrame(from.x(), from.y(), from.z(),
                             core::kPi / 2.0 - std::atan2(to.y() - from.y(), to.x() - from.x()))),
        length_m_((to - from).head<2>().norm()),
        rise_m_(to.z() - from.z()) {}
  double length_m() const { return length_m_; }
  double GroundAt(double x) const { return rise_m_ * x / length_m_; }
  Frame At(double x, double z) const { return frame_ * Shift(x, 0, GroundAt(x) + z); }
  /// A bar of a rectangular section from x0 to x1 that follows the ground.
  void Rail(SolidBuilder& solid, std::uint32_t material, double x0, double x1, double z0, double z1,
            double thick_m) const {
    const double y = thick_m / 2.0, g0 = GroundAt(x0), g1 = GroundAt(x1);
    std::array<Vector3d, 8> c{Vector3d(x0, -y, g0 + z0), Vector3d(x1, -y, g1 + z0),
                              Vector3d(x1, y, g1 + z0),  Vector3d(x0, y, g0 + z0),
                              Vector3d(x0, -y, g0 + z1), Vector3d(x1, -y, g1 + z1),
                              Vector3d(x1, y, g1 + z1),  Vector3d(x0, y, g0 + z1)};
    for (Vector3d& corner : c) corner = frame_ * corner;
    solid.Hexahedron(material, c);
  }

 private:
  Frame frame_;
  double length_m_;
  double rise_m_;
};

void Bars(Workshop& shop, const Leg& leg, double height, const Rgb& rgb) {
  const std::uint32_t paint = shop.materials.Paint(rgb, 0.04F);
  const std::uint32_t concrete = shop.materials.Add(Pattern::kConcrete, shop.dice.Next());
  const double l = leg.length_m();
  leg.Rail(shop.solid, concrete, 0, l, -0.3, 0.22, 0.16);
  for (const double z : {0.34, height - 0.12})
    leg.Rail(shop.solid, paint, 0, l, z, z + 0.045, 0.035);
  const int posts = std::max(1, static_cast<int>(std::lround(l / 2.0)));
  for (int i = 0; i <= posts; ++i)
    shop.solid.Box(paint, leg.At(l * i / posts, 0.1), {0.06, 0.06, height - 0.08});
  const int bars = static_cast<int>(l / 0.14);
  for (int i = 1; i < bars; ++i)
    shop.solid.Box(paint, leg.At(l * i / bars, 0.36), {0.018, 0.018, height - 0.40});
}

void Blocks(Workshop& shop, const Leg& leg, double height, const std::optional<Rgb>& rgb) {
  Material m = UsualMaterial(Pattern::kBrick);  // hollow concrete blocks, 19 cm courses
  const Rgb grey = rgb.value_or(Rgb{0.36, 0.355, 0.34});
  for (std::size_t i = 0; i < 3; ++i) {
    m.base_rgb[i] = static_cast<float>(grey[i]);
    m.second_rgb[i] = m.base_rgb[i] * 0.62F;
  }
  m.scale_m = 0.19F;
  m.contrast = 0.45F;
  m.seed = static_cast<std::uint32_t>(shop.dice.Next());
  const std::uint32_t block = shop.materials.Add(m);
  const std::uint32_t cap = shop.materials.Add(Pattern::kConcrete, shop.dice.Next());
  const double l = leg.length_m();
  leg.Rail(shop.solid, block, 0, l, -0.4, height - 0.07, 0.12);
  leg.Rail(shop.solid, cap, 0, l, height - 0.07, height, 0.16);
  const int buttresses = static_cast<int>(l / 3.2);
  for (int i = 1; i <= buttresses; ++i)
    shop.solid.Box(block, leg.At(l * i / (buttresses + 1.0), -0.3),
                   {0.19, 0.30, height - 0.1 + 0.3});
}

void Panels(Workshop& shop, const Leg& leg, double height, const std::optional<Rgb>& rgb) {
  const std::uint32_t sheet = shop.materials.Add(
      Pattern::kCorrugated, rgb.value_or(Rgb{0.62, 0.63, 0.62}), shop.dice.Next());
  const std::uint32_t post = shop.materials.Paint({0.34, 0.35, 0.36}, 0.06F);
  const double l = leg.length_m();
  leg.Rail(shop.solid, sheet, 0, l, 0.05, height, 0.03);
  const int posts = std::max(1, static_cast<int>(std::lround(l / 2.4)));
  for (int i = 0; i <= posts; ++i)
    shop.solid.Box(post, leg.At(l * i / posts, -0.2), {0.08, 0.10, height + 0.25});
  leg.Rail(shop.solid, post, 0, l, height - 0.02, height + 0.04, 0.07);
}

void Hedge(Workshop& shop, const Leg& leg, double height) {
  Dice& dice = shop.dice;
  const std::uint32_t shade =
      shop.materials.Add(Pattern::kLeaves, {0.02, 0.04, 0.012}, dice.Next());
  const std::uint32_t leaf = shop.materials.Add(Pattern::kLeaves, dice.Next());
  const double l = leg.length_m(), thick = 0.6;
  leg.Rail(shop.solid, shade, 0, l, 0.0, height - 0.08, thick - 0.16);
  const double around = 2.0 * height + thick;
  const int leaves = static_cast<int>(l * around * 55.0);
  for (int i = 0; i < leaves; ++i) {
    const double x = Between(dice, 0.0, l), s = Between(dice, 0.0, around);
    Vector3d at, out;
    if (s < height) {
      at = {x, -thick / 2, s}, out = {0, -1, 0};
    } else if (s < height + thick) {
      at = {x, s - height - thick / 2, height}, out = {0, 0, 1};
    } else {
      at = {x, thick / 2, around - s}, out = {0, 1, 0};
    }
    at -= out * Between(dice, 0.0, 0.10);
    const Frame frame = leg.At(at.x(), 0) * Frame(Eigen::Translation3d(0, at.y(), at.z()));
    const double turn = 2.0 * core::kPi * dice.Uniform(), size = Between(dice, 0.05, 0.11);
    const Vector3d tilt(Between(dice, -0.5, 0.5), Between(dice, -0.5, 0.5),
                        Between(dice, -0.5, 0.5));
    const Vector3d n = (out + tilt).normalized();
    const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    const auto corner = [&](double angle, double r) -> Vector3d {
      return frame * Vector3d((u * std::cos(turn + angle) + v * std::sin(turn + angle)) * r);
    };
    shop.solid.Quad(leaf, corner(0.0, size), corner(core::kPi / 2, size * 0.5),
                    corner(core::kPi, size), corner(3 * core::kPi / 2, size * 0.5));
  }
}

}  // namespace

void BuildFence(Workshop& shop, const FenceConfig& fence,
                const std::vector<Vector3d>& line_on_ground) {
  for (std::size_t i = 0; i + 1 < line_on_ground.size(); ++i) {
    const Leg leg(line_on_ground[i], line_on_ground[i + 1]);
    switch (fence.style) {
      case FenceStyle::kBars:
        Bars(shop, leg, fence.height_m, fence.rgb.value_or(Rgb{0.30, 0.36, 0.31}));
        break;
      case FenceStyle::kBlocks:
        Blocks(shop, leg, fence.height_m, fence.rgb);
        break;
      case FenceStyle::kPanels:
        Panels(shop, leg, fence.height_m, fence.rgb);
        break;
      case FenceStyle::kHedge:
        Hedge(shop, leg, fence.height_m);
        break;
    }
  }
}

}  // namespace kawara::sim
