#pragma once
#include <memory>

#include "core/counters.hpp"
#include "drivers/camera.hpp"
#include "drivers/v4l2_session.hpp"
#include "onboard/camera_reader.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// The camera of a configuration, and what is to be done with each of its frames.
struct CameraSource {
  std::unique_ptr<drivers::Camera> camera;  ///< null: the robot has none
  CameraReader::Watch watch;                ///< may be empty; uses the camera
};

CameraSource MakeCamera(const OnboardConfig& config, core::Counters& counters);

/// The driver's view of the configuration.
drivers::V4l2CameraConfig V4l2ConfigOf(const CameraConfig& camera);

}  // namespace kawara::onboard
