#pragma once
#include <string>

#include "core/expected.hpp"
#include "vision/camera/camera_choice.hpp"

/// A camera's optics as a YAML file.
namespace kawara::sim {

/// Errors: every mistake with its line, as core::config::Load, or what the model refuses.
core::Expected<vision::CameraChoice> LoadCamera(const std::string& path);

/// A file that LoadCamera reads back; without the sections of other models, so that the lines of a
/// doughnut also stand as they are under `picture` of a robot's configuration.
std::string DumpCamera(const vision::CameraChoice& choice);

}  // namespace kawara::sim
