#include "vision/camera/camera_choice.hpp"

#include <type_traits>
#include <utility>

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

namespace {

core::Expected<EquirectangularCamera> Make(const EquirectangularParameters& p) {
  return EquirectangularCamera::Create(p.Geometry());
}
core::Expected<DoughnutCamera> Make(const DoughnutParameters& p) {
  return DoughnutCamera::Create(p);
}
template <class Lens>
core::Expected<LensCamera> Make(const Lens& p) {
  return MakeLens(p);
}

}  // namespace

core::Expected<std::shared_ptr<const CameraModel>> MakeCamera(const CameraChoice& choice) {
  core::Expected<std::shared_ptr<const CameraModel>> camera = core::Fail(
      core::ErrorCode::kInvalidArgument, "camera = " + choice.camera + ": not a camera model");
  CameraChoice sections = choice;  // VisitSections serves reading too
  sections.VisitSections([&](const char* name, auto& section) {
    if (choice.camera != name) return;
    auto made = Make(section);
    if (!made) {
      camera = tl::unexpected(made.error());
    } else {
      using Model = typename std::decay_t<decltype(made)>::value_type;
      camera = std::make_shared<const Model>(std::move(*made));
    }
  });
  return camera;
}

}  // namespace kawara::vision
