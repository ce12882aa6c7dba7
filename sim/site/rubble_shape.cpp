#include <algorithm>
#include <array>
#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

/// Height of the heap's skin over the ground: a dome whose foot is ragged.
class HeapProfile {
 public:
  HeapProfile(const RubbleConfig& heap, Dice& dice) : heap_(heap) {
    for (Bump& bump : bumps_)
      bump = {2.0 * core::kPi * dice.Uniform(), Between(dice, 0.03, 0.12),
              2.0 * core::kPi * dice.Uniform()};
  }
  double At(double x, double y) const {
    const double turn = std::atan2(y / heap_.size_m[1], x / heap_.size_m[0]);
    double foot = 1.0;
    int k = 2;
    for (const Bump& bump : bumps_) foot += bump.depth * (std::sin(turn * k++ + bump.phase) - 1.0);
    const double r = std::hypot(2.0 * x / heap_.size_m[0], 2.0 * y / heap_.size_m[1]) / foot;
    if (r >= 1.0) return 0.0;
    const double lumps =
        0.85 + 0.15 * std::sin(1.9 * x + bumps_[0].twist) * std::sin(2.3 * y + bumps_[1].twist);
    return heap_.height_m * lumps * (1.0 - r * r) * (1.0 - 0.35 * r);
  }

 private:
  struct Bump {
    double phase, depth, twist;
  };
  const RubbleConfig& heap_;
  std::array<Bump, 5> bumps_{};
};

Frame AnyTurn(Dice& dice) {
  return TurnZ(2.0 * core::kPi * dice.Uniform()) * TurnX(Between(dice, -0.9, 0.9)) *
         TurnY(Between(dice, -0.9, 0.9));
}

/// A broken block: a box none of whose corners is where it was.
void Block(Workshop& shop, std::uint32_t material, const Frame& at, const Vector3d& size) {
  std::array<Vector3d, 8> c;
  for (std::size_t i = 0; i < 8; ++i) {
    const double x = (i % 4 == 1 || i % 4 == 2) ? 0.5 : -0.5;
    const double y = i % 4 >= 2 ? 0.5 : -0.5;
    const double z = i >= 4 ? 0.5 : -0.5;
    const Vector3d knock(Between(shop.dice, 0.72, 1.0), Between(shop.dice, 0.72, 1.0),
                         Between(shop.dice, 0.80, 1.0));
    c[i] = at * Vector3d(size.cwiseProduct(Vector3d(x, y, z)).cwiseProduct(knock));
  }
  shop.solid.Hexahedron(material, c);
}

/// The closed mound under the pieces, so that nobody looks through the heap.
void Mound(Workshop& shop, std::uint32_t material, const RubbleConfig& heap,
           const HeapProfile& profile, const LocalGround& ground) {
  const int nx = std::max(4, static_cast<int>(heap.size_m[0] / 0.35));
  const int ny = std::max(4, static_cast<int>(heap.size_m[1] / 0.35));
  constexpr double kUnder_m = -0.25;  // sides of the mound are underground
  constexpr double kHidden_m = -0.06;
  const auto point = [&](int i, int j) {
    const double x = heap.size_m[0] * (static_cast<double>(i) / nx - 0.5);
    const double y = heap.size_m[1] * (static_cast<double>(j) / ny - 0.5);
    const double z = profile.At(x, y);
    const bool rim = i == 0 || j == 0 || i == nx || j == ny || z <= 0.0;
    return Vector3d(x, y, ground(x, y) + (rim ? kHidden_m : 0.85 * z + kHidden_m));
  };
  double lowest = 0.0;
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j) lowest = std::min(lowest, point(i, j).z());
  const auto floor = [&](int i, int j) {
    Vector3d p = point(i, j);
    p.z() = lowest + kUnder_m;
    return p;
  };
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      const std::array top{point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)};
      shop.solid.Triangle(material, top[0], top[1], top[2]);
      shop.solid.Triangle(material, top[0], top[2], top[3]);
    }
  }
  shop.solid.Quad(material, floor(0, ny), floor(nx, ny), floor(nx, 0), floor(0, 0));
  for (int i = 0; i < nx; ++i) {
    shop.solid.Quad(material, floor(i, 0), floor(i + 1, 0), point(i + 1, 0), point(i, 0));
    shop.solid.Quad(material, floor(i + 1, ny), floor(i, ny), point(i, ny), point(i + 1, ny));
  }
  for (int j = 0; j < ny; ++j) {
    shop.solid.Quad(material, floor(nx, j), floor(nx, j + 1), point(nx, j + 1), point(nx, j));
    shop.solid.Quad(material, floor(0, j + 1), floor(0, j), point(0, j), point(0, j + 1));
  }
}

}  // namespace

void BuildRubble(Workshop& shop, const RubbleConfig& heap, const LocalGround& ground) {
  Dice& dice = shop.dice;
  Materials& m = shop.materials;
  const HeapProfile profile(heap, dice);
  const std::uint32_t dust = m.Add(Pattern::kRubble, dice.Next());
  const std::array stones{m.Add(Pattern::kRubble, dice.Next()),
                          m.Add(Pattern::kRubble, {0.46, 0.44, 0.40}, dice.Next()),
                          m.Add(Pattern::kRubble, {0.28, 0.26, 0.24}, dice.Next()),
                          m.Add(Pattern::kConcrete, dice.Next())};
  const std::uint32_t plaster = m.Add(Pattern::kConcrete, {0.55, 0.51, 0.43}, dice.Next());
  const std::uint32_t tile = m.Add(Pattern::kRubble, {0.13, 0.135, 0.145}, dice.Next());
  const std::uint32_t wood = m.Add(Pattern::kWood, dice.Next());
  const std::uint32_t pale_wood = m.Add(Pattern::kWood, {0.44, 0.31, 0.18}, dice.Next());
  const std::uint32_t rust = m.Paint({0.13, 0.055, 0.03}, 0.0F);
  Mound(shop, dust, heap, profile, ground);
  const int pieces = static_cast<int>(heap.pieces_per_m2 * heap.size_m[0] * heap.size_m[1]);
  for (int i = 0; i < pieces; ++i) {
    // Denser towards the middle; some have rolled beyond the foot.
    const double turn = 2.0 * core::kPi * dice.Uniform();
    const double r = std::sqrt(dice.Uniform()) * 0.5;
    const double x = heap.size_m[0] * r * std::cos(turn), y = heap.size_m[1] * r * std::sin(turn);
    const double foot_z = ground(x, y), z = foot_z + profile.At(x, y);
    const double size = 0.08 * std::pow(9.0, std::pow(dice.Uniform(), 2.2));  // 8 cm to 72 cm
    const Frame at = Shift(x, y, std::max(z, foot_z + 0.02) - 0.05 + size * 0.12) * AnyTurn(dice);
    const double kind = dice.Uniform();
    if (kind < 0.55) {
      Block(shop, stones[static_cast<std::size_t>(Pick(dice, 4))], at,
            Vector3d(size * Between(dice, 0.8, 1.5), size * Between(dice, 0.6, 1.0),
                     size * Between(dice, 0.4, 0.8)));
    } else if (kind < 0.70) {  // plaster boards and slabs
      Block(shop, plaster, at, Vector3d(size * 1.8, size * 1.3, Between(dice, 0.02, 0.06)));
    } else if (kind < 0.84) {
      Block(shop, tile, at, Vector3d(0.30, 0.27, 0.025));
    } else if (kind < 0.98) {  // boards and beams, flatter than stones lie
      const Frame lying = Shift(x, y, z + 0.02) * TurnZ(2.0 * core::kPi * dice.Uniform()) *
                          TurnY(Between(dice, -0.45, 0.45));
      shop.solid.Box(
          Chance(dice, 0.5) ? wood : pale_wood, lying,
          Vector3d(Between(dice, 0.4, 2.4), Between(dice, 0.06, 0.14), Between(dice, 0.02, 0.11)));
    } else {
      const Vector3d foot(x, y, z);
      const Vector3d tip = foot + Vector3d(Between(dice, -0.6, 0.6), Between(dice, -0.6, 0.6),
                                           Between(dice, 0.15, 0.7));
      shop.solid.Tube(rust, foot, tip, 0.008, 0.008, 6);
    }
  }
}

}  // namespace kawara::sim
