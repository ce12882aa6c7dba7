#include "vision/camera/camera_choice.hpp"

namespace kawara::vision {

PanoramaGeometry EquirectangularParameters::Geometry() const {
  PanoramaGeometry g;
  g.width_px = width_px;
  g.height_px = height_px;
  g.full_width_px = full_width_px > 0 ? full_width_px : width_px;
  g.full_height_px = full_height_px > 0 ? full_height_px : g.full_width_px / 2;
  g.left_px = left_px;
  g.top_px = top_px >= 0 ? top_px : (g.full_height_px - height_px) / 2;
  return g;
}

core::Expected<std::shared_ptr<const CameraModel>> MakeCamera(const CameraChoice& choice) {
  if (choice.camera == "equirectangular") {
    auto made = EquirectangularCamera::Create(choice.equirectangular.Geometry());
    if (!made) return tl::unexpected(made.error());
    return std::make_shared<const EquirectangularCamera>(*made);
  }
  if (choice.camera == "doughnut") {
    auto made = DoughnutCamera::Create(choice.doughnut);
    if (!made) return tl::unexpected(made.error());
    return std::make_shared<const DoughnutCamera>(*made);
  }
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "camera = " + choice.camera + ": expected doughnut or equirectangular");
}

}  // namespace kawara::vision
