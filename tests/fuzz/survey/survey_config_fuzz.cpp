#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "onboard/survey/survey_config.hpp"

/// Any bytes as camera.yaml: mistakes in words, or cameras whose models and mountings are either
/// refused or sound.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = survey::ParseSurveyConfig(text, "camera.yaml");
  if (!config) {
    if (config.error().message.empty()) std::abort();
    return 0;
  }
  for (const survey::CameraConfig& camera : config->cameras) {
    if (camera.mounting) {
      const auto pose = survey::BodyFromCamera(*camera.mounting, config->body_axes,
                                               survey::AxisOf(camera.optics));
      if (pose && std::abs(pose->linear().determinant() - 1.0) > 1e-9) std::abort();
    }
    if (camera.optics.camera.empty()) continue;
    const auto model = vision::MakeCamera(camera.optics);
    if (!model) continue;
    for (const Eigen::Vector3d& ray :
         {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.3, -0.2, 0.5), Eigen::Vector3d(-1, 1, -1)}) {
      const auto pixel = (*model)->Project(ray);
      if (pixel && !pixel->allFinite()) std::abort();
      const auto back = (*model)->Unproject({3.0 + ray.x(), 5.0 * ray.y()});
      if (back && std::abs(back->norm() - 1.0) > 1e-6) std::abort();
    }
  }
  return 0;
}
