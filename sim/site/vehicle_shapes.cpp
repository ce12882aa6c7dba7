#include <array>
#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

/// Takes an outline in (x, z) seen from the right side, drawn across the vehicle.
Frame SideOn() { return TurnX(core::kPi / 2.0); }

struct VehicleColours {
  std::uint32_t paint;
  std::uint32_t glass;
  std::uint32_t tyre;
  std::uint32_t hub;
  std::uint32_t dark;
  std::uint32_t lamp;
  std::uint32_t tail;
  std::uint32_t plate;
};

VehicleColours Colours(Workshop& shop, const Rgb& paint) {
  Materials& m = shop.materials;
  Material glass = UsualMaterial(Pattern::kGlass);
  glass.base_rgb = {0.02F, 0.024F, 0.026F};
  return {m.Paint(paint, 0.05F),
          m.Add(glass),
          m.Paint({0.022, 0.022, 0.023}, 0.0F),
          m.Paint({0.42, 0.43, 0.44}, 0.15F),
          m.Paint({0.03, 0.03, 0.032}, 0.01F),
          m.Paint({0.75, 0.76, 0.74}, 0.25F),
          m.Paint({0.38, 0.02, 0.015}, 0.08F),
          m.Paint({0.72, 0.73, 0.70}, 0.0F)};
}

/// Standing at (x, y) with its middle; axle across.
void Wheel(Workshop& shop, const VehicleColours& colours, double x, double y, double radius_m,
           double width_m) {
  const auto ring = [&](double across, double r) {
    return Ring{Vector3d(x, y + across, radius_m), Vector3d(r, 0, 0), Vector3d(0, 0, -r)};
  };
  const double h = width_m / 2.0;
  const std::array tyre{ring(-h, radius_m * 0.90), ring(-h * 0.75, radius_m),
                        ring(h * 0.75, radius_m), ring(h, radius_m * 0.90)};
  constexpr int kSides = 24;
  shop.solid.Loft(colours.tyre, tyre, kSides);
  const double hub = radius_m * 0.62;
  const std::array rim{ring(-h - 0.012, hub * 0.85), ring(-h + 0.01, hub), ring(h - 0.01, hub),
                       ring(h + 0.012, hub * 0.85)};
  shop.solid.Loft(colours.hub, rim, 12);
}

/// Points of an arch over a wheel from its rear foot to its front one, at sill height.
void AppendArch(std::vector<Vector2d>& outline, double x, double wheel_m, double arch_m,
                double sill_m) {
  const double foot = std::asin((sill_m - wheel_m) / arch_m);  // negative: below the axle
  constexpr int kSteps = 10;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = (core::kPi - foot) + (2.0 * foot - core::kPi) * i / kSteps;
    outline.emplace_back(x + arch_m * std::cos(angle), wheel_m + arch_m * std::sin(angle));
  }
}

/// The part with the windows: a frustum on the belt line.
struct Cabin {
  double rear_low, front_low, rear_top, front_top;  ///< x
  double half_low, half_top;                        ///< y
  double belt, roof;                                ///< z
  std::array<Vector3d, 8> Corners() const {
    return {Vector3d(rear_low, -half_low, belt), Vector3d(front_low, -half_low, belt),
            Vector3d(front_low, half_low, belt), Vector3d(rear_low, half_low, belt),
            Vector3d(rear_top, -half_top, roof), Vector3d(front_top, -half_top, roof),
            Vector3d(front_top, half_top, roof), Vector3d(rear_top, half_top, roof)};
  }
};

/// `side_windows`: shares of the side from the rear, begin and end of each pane.
void BuildCabin(Workshop& shop, const VehicleColours& colours, const Cabin& cabin,
                const std::vector<std::array<double, 2>>& side_windows) {
  const std::array<Vector3d, 8> c = cabin.Corners();
  shop.solid.Hexahedron(colours.paint, c);
  const std::array front{c[1], c[2], c[6], c[5]};
  const std::array rear{c[3], c[0], c[4], c[7]};
  constexpr double kProud_m = 0.006;
  shop.solid.Plate(colours.glass, front, 0.05, 0.95, 0.04, 0.93, kProud_m);
  shop.solid.Plate(colours.glass, rear, 0.08, 0.92, 0.12, 0.90, kProud_m);
  const std::array right{c[0], c[1], c[5], c[4]};
  const std::array left{c[2], c[3], c[7], c[6]};
  for (const auto& [begin, end] : side_windows) {
    shop.solid.Plate(colours.glass, right, begin, end, 0.08, 0.88, kProud_m);
    shop.solid.Plate(colours.glass, left, 1 - end, 1 - begin, 0.08, 0.88, kProud_m);
  }
  // Wipers' cowl
  shop.solid.Plate(colours.dark, front, 0.05, 0.95, 0.0, 0.03, kProud_m);
}

void Mirrors(Workshop& shop, const VehicleColours& colours, double x, double y, double z,
             const Vector3d& size) {
  for (const double side : {-1.0, 1.0}) shop.solid.Box(colours.dark, Shift(x, side * y, z), size);
}

void LampsAndPlates(Workshop& shop, const VehicleColours& c, double length, double width,
                    double lamp_z, double tail_z, double tail_height) {
  const double x = length / 2.0;
  for (const double side : {-1.0, 1.0}) {
    shop.solid.Box(c.lamp, Shift(x - 0.04, side * (width / 2 - 0.24), lamp_z), {0.10, 0.34, 0.14});
    shop.solid.Box(c.tail, Shift(-x + 0.03, side * (width / 2 - 0.12), tail_z),
                   {0.09, 0.20, tail_height});
  }
  shop.solid.Box(c.plate, Shift(x + 0.005, 0, 0.38), {0.02, 0.33, 0.165});
  shop.solid.Box(c.plate, Shift(-x - 0.005, 0, 0.52), {0.02, 0.33, 0.165});
  shop.solid.Box(c.dark, Shift(x - 0.01, 0, lamp_z - 0.02), {0.05, width * 0.42, 0.11});
}

/// Door gaps and handles on both sides; `gaps`: x of the gaps between sill and belt.
void Doors(Workshop& shop, const VehicleColours& c, double half_width, double sill, double belt,
           const std::vector<double>& gaps) {
  for (const double side : {-1.0, 1.0}) {
    for (const double x : gaps) {
      shop.solid.Box(c.dark, Shift(x, side * half_width, sill + 0.06),
                     {0.012, 0.006, belt - sill - 0.08});
      shop.solid.Box(c.dark, Shift(x + 0.16, side * half_width, belt - 0.14), {0.18, 0.05, 0.03});
    }
    shop.solid.Box(c.dark, Shift(0, side * half_width, sill), {half_width * 1.9, 0.03, 0.07});
  }
}

}  // namespace

void BuildCar(Workshop& shop, const Size& size, const Rgb& paint) {
  const VehicleColours c = Colours(shop, paint);
  const double l = size.length_m, w = size.width_m - 0.10, h = size.height_m;
  const double wheel = 0.215 * h, arch = wheel + 0.05, sill = 0.15 * h;
  const double front = 0.30 * l, rear = -0.285 * l;
  std::vector<Vector2d> body{{-l / 2 + 0.06, 0.22 * h}, {-l / 2 + 0.28, sill}};
  AppendArch(body, rear, wheel, arch, sill);
  AppendArch(body, front, wheel, arch, sill);
  for (const Vector2d& p :
       {Vector2d(l / 2 - 0.22, sill), Vector2d(l / 2 - 0.02, 0.19 * h), Vector2d(l / 2, 0.30 * h),
        Vector2d(l / 2 - 0.02, 0.44 * h), Vector2d(l / 2 - 0.14, 0.50 * h),
        Vector2d(l / 2 - 0.45, 0.555 * h), Vector2d(0.215 * l, 0.62 * h),
        Vector2d(-0.36 * l, 0.66 * h), Vector2d(-l / 2 + 0.10, 0.63 * h),
        Vector2d(-l / 2 + 0.01, 0.56 * h), Vector2d(-l / 2, 0.34 * h)})
    body.push_back(p);
  shop.solid.ChamferedPrism(c.paint, SideOn(), body, -w / 2, w / 2, 0.035);
  shop.solid.Box(c.dark, Shift(0, 0, sill + 0.02), {l * 0.92, w - 0.44, 0.30 * h});
  BuildCabin(shop, c,
             {-0.415 * l, 0.225 * l, -0.30 * l, 0.045 * l, w / 2 - 0.03, w / 2 - 0.20, 0.63 * h, h},
             {{0.16, 0.47}, {0.50, 0.88}});
  for (const double x : {front, rear})
    for (const double y : {-w / 2 + 0.10, w / 2 - 0.10}) Wheel(shop, c, x, y, wheel, 0.195);
  LampsAndPlates(shop, c, l, w, 0.42 * h, 0.48 * h, 0.15);
  Mirrors(shop, c, 0.17 * l, w / 2 + 0.0, 0.63 * h, {0.10, 0.20, 0.13});
  Doors(shop, c, w / 2, sill, 0.62 * h, {-0.20 * l, 0.01 * l});
}

void BuildWagon(Workshop& shop, const Size& size, const Rgb& paint) {
  const VehicleColours c = Colours(shop, paint);
  const double l = size.length_m, w = size.width_m - 0.12, h = size.height_m;
  const double wheel = 0.165 * h, arch = wheel + 0.055, sill = 0.125 * h, belt = 0.53 * h;
  const double front = 0.315 * l, rear = -0.27 * l;
  std::vector<Vector2d> body{{-l / 2 + 0.02, 0.17 * h}, {-l / 2 + 0.25, sill}};
  AppendArch(body, rear, wheel, arch, sill);
  AppendArch(body, front, wheel, arch, sill);
  for (const Vector2d& p :
       {Vector2d(l / 2 - 0.15, sill), Vector2d(l / 2, 0.17 * h), Vector2d(l / 2, 0.34 * h),
        Vector2d(l / 2 - 0.07, 0.42 * h), Vector2d(l / 2 - 0.30, belt), Vector2d(-l / 2, belt)})
    body.push_back(p);
  shop.solid.ChamferedPrism(c.paint, SideOn(), body, -w / 2, w / 2, 0.035);
  shop.solid.Box(c.dark, Shift(0, 0, sill + 0.02), {l * 0.92, w - 0.44, 0.26 * h});
  BuildCabin(shop, c,
             {-l / 2, l / 2 - 0.30, -l / 2 + 0.10, l / 2 - 1.05, w / 2, w / 2 - 0.10, belt, h},
             {{0.05, 0.34}, {0.365, 0.655}, {0.69, 0.93}});
  for (const double x : {front, rear})
    for (const double y : {-w / 2 + 0.11, w / 2 - 0.11}) Wheel(shop, c, x, y, wheel, 0.20);
  LampsAndPlates(shop, c, l, w, 0.33 * h, 0.36 * h, 0.42);
  Mirrors(shop, c, l / 2 - 0.55, w / 2 + 0.01, belt + 0.02, {0.10, 0.20, 0.24});
  Doors(shop, c, w / 2, sill, belt, {-0.12 * l, 0.16 * l});
}

void BuildTruck(Workshop& shop, const Size& size, const Rgb& paint) {
  const VehicleColours c = Colours(shop, paint);
  const std::uint32_t panel = shop.materials.Paint({0.62, 0.63, 0.62}, 0.02F);
  const std::uint32_t trim = shop.materials.Paint({0.36, 0.37, 0.38}, 0.06F);
  const double l = size.length_m, w = size.width_m - 0.16, h = size.height_m;
  const double wheel = 0.39, bed = 0.95, cab = 1.75, cab_top = std::min(2.15, h - 0.15);
  const double nose = l / 2, back = nose - cab;
  // Cab, seen from the side.
  std::vector<Vector2d> outline{{back, 0.55}};
  AppendArch(outline, nose - 0.82, wheel, wheel + 0.09, 0.55);
  for (const Vector2d& p : {Vector2d(nose - 0.12, 0.42), Vector2d(nose, 0.45), Vector2d(nose, 1.18),
                            Vector2d(nose - 0.04, 1.26), Vector2d(nose - 0.32, cab_top - 0.08),
                            Vector2d(nose - 0.45, cab_top), Vector2d(back, cab_top)})
    outline.push_back(p);
  shop.solid.ChamferedPrism(c.paint, SideOn(), outline, -w / 2, w / 2, 0.03);
  const double y = w / 2;
  const std::array front{Vector3d(nose - 0.04, -y, 1.26), Vector3d(nose - 0.04, y, 1.26),
                         Vector3d(nose - 0.32, y, cab_top - 0.08),
                         Vector3d(nose - 0.32, -y, cab_top - 0.08)};
  shop.solid.Plate(c.glass, front, 0.05, 0.95, 0.02, 0.92, 0.008);
  for (const double side : {-1.0, 1.0}) {
    // Side panes follow the slope of the windscreen.
    const auto at = [&](double x, double z) { return Vector3d(x, side * y, z); };
    std::array pane{at(back + 0.38, 1.28), at(nose - 0.28, 1.28), at(nose - 0.48, cab_top - 0.18),
                    at(back + 0.38, cab_top - 0.18)};
    if (side > 0) std::swap(pane[0], pane[1]), std::swap(pane[2], pane[3]);
    shop.solid.Plate(c.glass, pane, 0, 1, 0, 1, 0.008);
    shop.solid.Box(c.dark, Shift(back + 0.34, side * y, 0.68), {0.012, 0.008, cab_top - 0.80});
    shop.solid.Box(c.dark, Shift(back + 0.50, side * y, 1.12), {0.20, 0.06, 0.035});
    shop.solid.Box(c.lamp, Shift(nose - 0.03, side * (y - 0.26), 0.74), {0.09, 0.36, 0.18});
    shop.solid.Box(c.dark, Shift(nose - 0.05, side * (y + 0.045), 1.35), {0.08, 0.09, 0.40});
    shop.solid.Box(c.dark, Shift(nose - 1.25, side * (y - 0.12), 0.42), {0.35, 0.28, 0.06});
    // Chassis rail, tank, guard rails.
    shop.solid.Box(c.dark, Shift(-cab / 2 + 0.1, side * 0.40, 0.62), {l - cab - 0.2, 0.09, 0.22});
    shop.solid.Box(side > 0 ? trim : c.dark, Shift(back - 0.75, side * (y - 0.30), 0.45),
                   {0.75, 0.42, 0.36});
    for (const double z : {0.50, 0.70})
      shop.solid.Box(trim, Shift(back - 1.9, side * (y - 0.06), z), {1.25, 0.03, 0.08});
    shop.solid.Box(c.tail, Shift(-l / 2 + 0.05, side * (y - 0.24), 0.66), {0.08, 0.34, 0.12});
  }
  shop.solid.Box(c.dark, Shift(nose + 0.01, 0, 0.40), {0.10, w * 0.98, 0.24});
  shop.solid.Box(c.dark, Shift(nose, 0, 0.92), {0.03, w * 0.55, 0.16});
  shop.solid.Box(c.plate, Shift(nose + 0.06, 0, 0.44), {0.02, 0.33, 0.165});
  shop.solid.Box(c.dark, Shift(-l / 2 + 0.06, 0, 0.50), {0.10, w * 0.92, 0.10});
  // Box body with its edge trims.
  const double box_l = l - cab - 0.10, box_x = -l / 2 + box_l / 2, box_w = size.width_m - 0.02;
  const double box_h = h - bed;
  shop.solid.Box(panel, Shift(box_x, 0, bed), {box_l - 0.02, box_w, box_h - 0.01});
  shop.solid.Box(c.dark, Shift(box_x, 0, bed - 0.12), {box_l - 0.1, w - 0.1, 0.12});
  for (const double x : {box_x - box_l / 2 + 0.03, box_x + box_l / 2 - 0.03}) {
    for (const double side : {-1.0, 1.0})
      shop.solid.Box(trim, Shift(x, side * (box_w / 2 - 0.02), bed), {0.06, 0.06, box_h});
  }
  for (const double side : {-1.0, 1.0}) {
    for (const double z : {bed, h - 0.08})
      shop.solid.Box(trim, Shift(box_x, side * (box_w / 2 - 0.02), z), {box_l, 0.06, 0.08});
    const int ribs = static_cast<int>(box_l / 0.85);
    for (int i = 1; i < ribs; ++i)
      shop.solid.Box(trim,
                     Shift(box_x - box_l / 2 + box_l * i / ribs, side * box_w / 2, bed + 0.08),
                     {0.035, 0.012, box_h - 0.16});
    // Rear doors: lock bars either side of the middle.
    shop.solid.Box(trim, Shift(-l / 2 + 0.01, side * 0.35, bed + 0.05), {0.04, 0.035, box_h - 0.1});
  }
  shop.solid.Box(c.dark, Shift(-l / 2 + 0.01, 0, bed + 0.03), {0.014, 0.015, box_h - 0.06});
  shop.solid.Box(c.plate, Shift(-l / 2, 0.3, 0.62), {0.02, 0.33, 0.165});
  for (const double side : {-1.0, 1.0}) {
    Wheel(shop, c, nose - 0.82, side * (y - 0.13), wheel, 0.22);
    Wheel(shop, c, -l / 2 + 1.35, side * (y - 0.12), wheel, 0.20);
    Wheel(shop, c, -l / 2 + 1.35, side * (y - 0.36), wheel, 0.20);
  }
}

}  // namespace kawara::sim
