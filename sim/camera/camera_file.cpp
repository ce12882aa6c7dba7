#include "sim/camera/camera_file.hpp"

#include <sstream>

#include "core/config/config.hpp"

namespace kawara::sim {

core::Expected<vision::CameraChoice> LoadCamera(const std::string& path) {
  auto choice = core::config::Load<vision::CameraChoice>(path);
  if (!choice) return choice;
  if (const auto camera = vision::MakeCamera(*choice); !camera) {
    return core::Fail(camera.error().code, path + ": " + camera.error().message);
  }
  return choice;
}

std::string DumpCamera(const vision::CameraChoice& choice) {
  std::string text = "camera: " + choice.camera + "\n" + choice.camera + ":\n";
  std::istringstream lines;
  vision::CameraChoice sections = choice;
  sections.VisitSections([&](const char* name, const auto& section) {
    if (choice.camera == name) lines.str(core::config::Dump(section));
  });
  for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
  return text;
}

}  // namespace kawara::sim
