#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "drivers/v4l2_session.hpp"

/// What kawara-camera can be told to do. Each prints to standard output and returns the exit status
/// (0: done; 1: the camera went away or did not keep what was asked); an error is one line and 2.
namespace kawara::tools {

/// The camera and its mode as the command line gives them.
struct CameraOptions {
  std::string device;  ///< empty: the only one there is
  std::string size;    ///< "1920x1080"; empty: the largest
  double rate_hz = 10.0;
  std::string format;                 ///< empty: the preferred one
  std::vector<std::string> settings;  ///< NAME=VALUE
  double exposure_s = 0.0;
  double readout_s = 0.0;
  double patience_s = 10.0;  ///< how long to wait for a frame
};

core::Expected<drivers::V4l2CameraConfig> ConfigOf(const CameraOptions& options);
/// The device given, or the only capture device of this machine. kNotFound: none, or several (and
/// which).
core::Expected<std::string> DeviceOf(const std::string& device);
/// "NAME=VALUE" each.
core::Expected<drivers::V4l2Settings> ParseSettings(const std::vector<std::string>& settings);

core::Expected<int> CameraList();
core::Expected<int> CameraControls(const std::string& device,
                                   const std::vector<std::string>& settings);
/// Writes one frame, after `skip` others in which automatics settle, as .jpg or .png.
core::Expected<int> CameraGrab(const CameraOptions& options, const std::string& file, int skip);
/// Prints `count` frames, each on a line unless `quiet`, and what became of them.
core::Expected<int> CameraStream(const CameraOptions& options, int count, bool quiet);

}  // namespace kawara::tools
