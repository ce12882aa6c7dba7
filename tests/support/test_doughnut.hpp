#pragma once
#include "vision/camera/doughnut_camera.hpp"

namespace kawara::vision {

/// 272 px/rad ring of 1024 x 1024 px, +30 to -50 deg, made larger or smaller.
inline DoughnutParameters TestDoughnut(int size_px = 1024) {
  const double scale = size_px / 1024.0;
  DoughnutParameters p;
  p.width_px = p.height_px = size_px;
  p.center_u_px = p.center_v_px = 512.0 * scale - 0.5;
  p.l_in_px = 120.0 * scale;
  p.l_base_px = 262.5 * scale;
  p.l_out_px = 500.0 * scale;
  return p;
}

/// With the correction of a real mirror, made up: the horizon lies where the circles then put it.
inline DoughnutParameters CorrectedDoughnut(DoughnutParameters p) {
  p.correction = {0.02, -0.004, 0.0005, 0.0};
  const OddPolynomial unit{p.correction};
  const double side = p.phi_top_deg > p.phi_bottom_deg ? 1.0 : -1.0;
  const double inner = unit.Value((90.0 - side * p.phi_top_deg) * core::kRadFromDeg);
  const double outer = unit.Value((90.0 - side * p.phi_bottom_deg) * core::kRadFromDeg);
  p.l_base_px =
      p.l_in_px + (p.l_out_px - p.l_in_px) * (unit.Value(core::kPi / 2) - inner) / (outer - inner);
  return p;
}

}  // namespace kawara::vision
