#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <vector>

#include "sim/render/lens.hpp"
#include "sim/render/lit_scene.hpp"
#include "sim/render/robot_body.hpp"
#include "sim/render/sensor.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"

namespace kawara::sim {

/// How a camera works, the same for all its frames.
struct CameraSettings {
  /// Light of a pixel is the mean of this many rays where something ends or a shadow falls; one ray
  /// suffices elsewhere, because surfaces are averaged over the pixel beforehand. Odd (the pixel's
  /// centre and pairs round it); even numbers count as the next odd one.
  int samples = 3;
  /// Pixels that move further than this during the exposure take more rays along the way.
  double still_px = 1.0;
  int max_blur_samples = 17;
  int threads = 0;  ///< 0: all the machine has
  LensSettings lens;
  SensorSettings sensor;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("samples", samples, Range{1, 17}, Optional{});
    v("still_px", still_px, Range{0.05, 100}, Optional{});
    v("max_blur_samples", max_blur_samples, Range{1, 17}, Optional{});
    v("threads", threads, Range{0, 256}, Optional{});
    v("lens", lens, Optional{});
    v("sensor", sensor, Optional{});
  }
};

/// One exposure.
struct RenderRequest {
  /// The camera's pose (origin: the viewpoint; axes: vision/camera/camera_model.hpp) as a function
  /// of seconds from mid-exposure of the middle row. Asked within half the exposure and half the
  /// readout of 0, from one thread.
  std::function<Eigen::Isometry3d(double)> enu_from_camera;
  double time_s = 0.0;      ///< of the mission: which objects exist
  double exposure_s = 0.0;  ///< motion blur; its brightness is the sensor's gain
  double readout_s = 0.0;   ///< rolling shutter: from the first row's exposure to the last row's
  std::uint64_t noise_seed = 1;  ///< another for each frame
};

/// What the camera delivers, and the truth beside it, rows from the top.
struct RenderedFrame {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;
  /// Distance along the ray of the pixel's CENTRE at the middle of its row's exposure [m];
  /// infinity: sky; NaN: outside the field of view.
  std::vector<float> range_m;
  std::vector<std::uint32_t> object;  ///< 0: sky or outside; kRobotBodyObject
  double gain = 0.0;                  ///< the sensor's, as chosen
  double mean_light = 0.0;            ///< of all pixels that see something, before gain

  vision::ConstImageView view() const { return {rgb.data(), width_px, height_px}; }
};

/// A camera in a scene. The same request gives the same bytes, whatever the number of threads.
/// Render() may be called from any number of threads at once (it works with `threads` of oneTBB's).
class Renderer {
 public:
  Renderer(std::shared_ptr<const LitScene> scene, std::shared_ptr<const vision::CameraModel> camera,
           const CameraSettings& settings, const RobotBody& body = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  RenderedFrame Render(const RenderRequest& request) const;

  const vision::CameraModel& camera() const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// A camera that stands still.
inline std::function<Eigen::Isometry3d(double)> Still(const Eigen::Isometry3d& enu_from_camera) {
  return [enu_from_camera](double) { return enu_from_camera; };
}

/// Pose of an upright camera: looks along `heading_rad` (true, clockwise from north), level.
Eigen::Isometry3d UprightCamera(const Eigen::Vector3d& place_enu_m, double heading_rad);

}  // namespace kawara::sim
