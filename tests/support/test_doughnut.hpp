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

}  // namespace kawara::vision
