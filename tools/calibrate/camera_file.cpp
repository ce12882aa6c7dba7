#include "tools/calibrate/camera_file.hpp"

#include "core/config/writer.hpp"
#include "tools/calibrate/printed.hpp"

namespace kawara::calibrate {
namespace {

/// A comment ends with its line.
std::string OneLine(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return text;
}

}  // namespace

std::string CameraFileOf(const vision::CameraCalibration& made, const std::string& origin) {
  std::string file = "# Calibrated by kawara-calibrate from " + OneLine(origin) + ".\n";
  file += Printed("# Residuals %.3f px rms, of pictures it was not fitted to %.3f px rms.\n",
                  made.fit.rms_px, made.cross_validated_px);
  file += Printed("# Directions are projected to %.3f px (1 sigma) at the worst.\n",
                  made.projection_sd_px);
  for (const vision::EstimatedNumber& number : made.numbers) {
    file += Printed("#   %-12s %.10g +- %.2g\n", number.name.c_str(), number.value, number.sd);
  }
  core::config::Writer writer;
  vision::CameraChoice optics = made.optics;
  writer("camera", optics.camera);
  optics.VisitSections([&](const char* key, auto& section) {
    if (key == optics.camera) writer(key, section);
  });
  return file + writer.text();
}

}  // namespace kawara::calibrate
