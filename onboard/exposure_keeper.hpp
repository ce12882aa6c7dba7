#pragma once
#include <functional>
#include <string>

#include "core/counters.hpp"
#include "core/expected.hpp"
#include "drivers/camera.hpp"
#include "onboard/camera_config.hpp"
#include "vision/jpeg.hpp"
#include "vision/phase1_picture.hpp"

namespace kawara::onboard {

/// Keeps a camera's pictures rightly exposed: looks at one now and then (JPEGs reduced to an eighth
/// while decoding), asks vision::AutoExposure, and sets the camera's controls. Of a doughnut only
/// its ring is looked at. Camera thread only.
///
/// Counters: camera.exposure.set, .refused (the camera took no value), .unreadable (no picture);
/// camera.exposure.exposure_us and .gain_percent are the setting in force.
class ExposureKeeper {
 public:
  /// Sets controls by name; V4l2Camera::Set.
  using Set = std::function<core::Expected<void>(const core::config::NamedTexts&)>;

  ExposureKeeper(const ExposureSettings& settings, const vision::Phase1PictureConfig& picture,
                 core::Counters& counters, Set set);
  void OnFrame(const drivers::Frame& frame);

 private:
  core::Expected<vision::LightHistogram> Measure(const drivers::Frame& frame);
  void Apply(const vision::ExposureSetting& wanted, core::MonoTime now);

  ExposureSettings settings_;
  vision::AutoExposure control_;
  vision::MeteringArea area_;
  double area_width_px_;  ///< of the picture that area_ is meant for
  vision::JpegDecoder decoder_;
  Set set_;
  bool begun_ = false;
  core::MonoTime next_;
  core::Counter& sets_;
  core::Counter& refused_;
  core::Counter& unreadable_;
  core::Counter& exposure_us_;
  core::Counter& gain_percent_;
};

}  // namespace kawara::onboard
