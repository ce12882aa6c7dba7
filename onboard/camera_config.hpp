#pragma once
#include <Eigen/Core>
#include <string>

#include "core/config/constraints.hpp"
#include "vision/auto_exposure.hpp"

namespace kawara::onboard {

/// Exposure set by this computer instead of the camera's own automatic.
struct ExposureSettings {
  bool enabled = false;
  vision::AutoExposureConfig rule;
  double period_s = 0.1;  ///< between two pictures looked at
  std::string exposure_control = "exposure_time_absolute";
  double exposure_unit_s = 1e-4;  ///< of that control's numbers
  std::string gain_control;       ///< empty: gain is not touched
  double gain_unity = 1.0;        ///< number of the gain control that is factor 1; proportional

  template <class V>
  void Visit(V& v) {
    using namespace core::config;  // NOLINT(google-build-using-namespace)
    v("enabled", enabled);
    v("rule", rule, Optional{});
    v("period_s", period_s, Range{0.0, 60.0}, Optional{});
    v("exposure_control", exposure_control, NotEmpty{}, Optional{});
    v("exposure_unit_s", exposure_unit_s, Range{1e-7, 1.0}, Optional{});
    v("gain_control", gain_control, Optional{});
    v("gain_unity", gain_unity, Range{1e-3, 1e6}, Optional{});
  }
};

/// How a camera of the kernel's is made to expose.
struct TriggerSection {
  std::string by = "nothing";  ///< it runs freely; or a control, a GPIO line, RTS or DTR of a port
  std::string control;         ///< set to 1 for each exposure
  std::string device;          ///< GPIO chip (`gpiodetect`), or the serial port
  std::string line;            ///< GPIO: number on the chip or name (`gpioinfo`)
  bool active_low = false;
  double pulse_s = 0.001;

  template <class V>
  void Visit(V& v) {
    using namespace core::config;  // NOLINT(google-build-using-namespace)
    v("by", by, OneOf{"nothing", "control", "gpio", "rts", "dtr"});
    v("control", control, Optional{});
    v("device", device, Optional{});
    v("line", line, Optional{});
    v("active_low", active_low, Optional{});
    v("pulse_s", pulse_s, Range{1e-5, 0.1}, Optional{});
    v.Require(by != "control" || !control.empty(), "control",
              "the camera's trigger control (`kawara-camera controls` shows them)");
    v.Require((by != "gpio" && by != "rts" && by != "dtr") || !device.empty(), "device",
              "the GPIO chip or serial port");
    v.Require(by != "gpio" || !line.empty(), "line", "the line's number or name");
  }
};

/// A camera of the kernel's (source: v4l2). What a camera offers and which controls it has is told
/// by `kawara-camera list` and `kawara-camera controls`.
struct V4l2Section {
  std::string device;  ///< /dev/v4l/by-id/..., /dev/videoN, a bus (usb-...) or the camera's name
  int width_px = 0;    ///< 0 with height 0: the largest that is fast enough
  int height_px = 0;
  double rate_hz = 10.0;              ///< at least; the slowest such rate is taken
  std::string format = "auto";        ///< auto: the first of those below that the camera has
  core::config::NamedTexts controls;  ///< set at each opening; switches and menus first
  double readout_s = 0.0;    ///< end of exposure to end of frame, for cameras that stamp the latter
  double hang_s = 3.0;       ///< no frame for so long: the camera is restarted; 0: never
  double reconnect_s = 0.5;  ///< between two tries to open it
  TriggerSection trigger;
  ExposureSettings auto_exposure;

  template <class V>
  void Visit(V& v) {
    using namespace core::config;  // NOLINT(google-build-using-namespace)
    v("device", device, Optional{});
    v("width_px", width_px, Range{0, 32768}, Optional{});
    v("height_px", height_px, Range{0, 32768}, Optional{});
    v("rate_hz", rate_hz, Range{0.01, 1000.0}, Optional{});
    v("format", format,
      OneOf{"auto", "MJPG", "JPEG", "NV12", "YUYV", "RGGB", "BGGR", "GBRG", "GRBG", "GREY"},
      Optional{});
    v("controls", controls, Optional{});
    v("readout_s", readout_s, Range{0.0, 1.0}, Optional{});
    v("hang_s", hang_s, Range{0.0, 3600.0}, Optional{});
    v("reconnect_s", reconnect_s, Range{0.05, 60.0}, Optional{});
    v("trigger", trigger, Optional{});
    v("auto_exposure", auto_exposure, Optional{});
    v.Require((width_px == 0) == (height_px == 0), "height_px",
              "both width_px and height_px, or neither");
  }
};

struct CameraConfig {
  std::string source = "socket";  ///< "none": the robot has no eyes, navigation only
  std::string path;               ///< of the camera's UNIX socket
  V4l2Section v4l2;               ///< with source: v4l2
  std::string make;               ///< for EXIF; empty: left out
  std::string model;
  double trigger_lead_s = 0.0;  ///< trigger to start of exposure
  double exposure_s = 0.0;      ///< the pose is that of mid-exposure
  /// What is wired to the receiver's event input: nothing, the line that triggers the camera, or
  /// the camera's own sign that it exposes (strobe). The receiver's time of it is then the
  /// exposure's ($PASHR,TTT: 1 us).
  std::string event_mark = "none";
  double pairing_window_s =
      0.1;  ///< how far it may lie off its trigger; of no use if it runs freely
  Eigen::Vector3d position_frd_m = Eigen::Vector3d::Zero();  ///< from the body's reference point

  /// Takes pictures at its own times; of those one near each trigger is taken (PairingFor).
  bool RunsFreely() const { return source == "v4l2" && v4l2.trigger.by == "nothing"; }

  template <class V>
  void Visit(V& v) {
    using namespace core::config;  // NOLINT(google-build-using-namespace)
    v("source", source, OneOf{"socket", "v4l2", "none"});
    v("path", path, Optional{});
    v("v4l2", v4l2, Optional{});
    v("make", make, Optional{});
    v("model", model, Optional{});
    v("trigger_lead_s", trigger_lead_s, Range{0.0, 1.0}, Optional{});
    v("exposure_s", exposure_s, Range{0.0, 1.0}, Optional{});
    v("event_mark", event_mark, OneOf{"none", "trigger", "exposure"}, Optional{});
    v("pairing_window_s", pairing_window_s, Range{0.001, 1.0}, Optional{});
    v("position_frd_m", position_frd_m, Range{-20.0, 20.0}, Optional{});
    v.Require(source != "socket" || !path.empty(), "path", "the path of the camera's socket");
    v.Require(event_mark != "trigger" || !RunsFreely(), "event_mark",
              "exposure, or none: a camera that runs freely has no trigger");
    v.Require(source != "v4l2" || !v4l2.device.empty(), "v4l2",
              "a section with the camera's device (`kawara-camera list` shows them)");
  }
};

}  // namespace kawara::onboard
