#pragma once
#include "vision/camera/doughnut_camera.hpp"

namespace kawara::sim {

/// The standard doughnut (vision::DoughnutParameters as it is, 1024 x 1024) in a picture of another
/// size.
inline vision::DoughnutParameters StandardDoughnut(int side_px) {
  vision::DoughnutParameters p;
  const double factor = static_cast<double>(side_px) / p.width_px;
  p.width_px = p.height_px = side_px;
  p.center_u_px = p.center_v_px = (side_px - 1) / 2.0;
  p.l_in_px *= factor;
  p.l_base_px *= factor;
  p.l_out_px *= factor;
  return p;
}

}  // namespace kawara::sim
