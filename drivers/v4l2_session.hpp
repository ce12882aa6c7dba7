#pragma once
#include <memory>
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "drivers/trigger_line.hpp"
#include "drivers/v4l2_controls.hpp"
#include "drivers/v4l2_device.hpp"
#include "drivers/v4l2_finder.hpp"
#include "drivers/v4l2_stamps.hpp"
#include "drivers/v4l2_stream.hpp"

namespace kawara::drivers {

/// A camera as a robot's configuration wants it.
struct V4l2CameraConfig {
  std::string device;  ///< as V4l2Finder takes it
  V4l2ModeWish mode;
  V4l2Settings controls;  ///< set at each opening, in this order (see V4l2Controls::Set)
  V4l2StampRule stamps;   ///< exposure: where the camera does not tell its own
  core::Duration hang = core::Seconds(3);  ///< no frame for so long: restarted; 0: never
  core::Duration reconnect = core::Milliseconds(500);  ///< between two tries to open
  /// Control whose setting to 1 makes one exposure (maker's own; V4L2 has no standard one). Empty:
  /// none.
  std::string trigger_control;
  /// Or the wire its trigger input hangs on.
  TriggerLineConfig trigger_line;

  bool IsTriggered() const {
    return !trigger_control.empty() || trigger_line.kind != TriggerLineConfig::Kind::kNone;
  }
};

/// One opening of a camera: device, format, controls, stream, in the order they come to be. Closed
/// by destruction, in reverse. One thread.
class V4l2Session {
 public:
  /// Errors: those of the parts, naming the device; kInvalidArgument for what the configuration
  /// asks and the camera does not have.
  static core::Expected<std::unique_ptr<V4l2Session>> Open(V4l2Finder& finder,
                                                           const V4l2CameraConfig& config);

  V4l2Device& device() { return device_; }
  const V4l2Controls& controls() const { return *controls_; }
  V4l2Stream& stream() { return *stream_; }
  const V4l2PictureFormat& format() const { return format_; }
  /// Between two frames; not known where the device does not say.
  V4l2Interval interval() const { return interval_; }
  /// How long the shutter is open, if the camera says so (V4L2_CID_EXPOSURE_ABSOLUTE while no
  /// automatic changes it).
  std::optional<core::Duration> Exposure() const;
  /// "/dev/video0: HD Pro Webcam C920 (usb-0000:00:14.0-1), MJPG 1920x1080 at 30 Hz, 6 buffers".
  std::string Description() const;

 private:
  explicit V4l2Session(V4l2Device device) : device_(std::move(device)) {}

  V4l2Device device_;
  std::optional<V4l2Controls> controls_;
  V4l2PictureFormat format_;
  V4l2Interval interval_;
  std::optional<V4l2Stream> stream_;
};

}  // namespace kawara::drivers
