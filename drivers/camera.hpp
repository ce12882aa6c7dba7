#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

enum class PixelFormat : std::uint32_t { kJpeg = 1, kRgb8 = 2, kGrey8 = 3 };

/// One exposure. `bytes` is the compressed picture (kJpeg) or packed rows without padding.
struct Frame {
  std::uint32_t sequence = 0;          ///< counted by the camera, gaps are lost frames
  std::uint32_t trigger_sequence = 0;  ///< which trigger made it, as the camera knows; 0 unknown
  core::MonoTime exposure_start;       ///< start of exposure on this machine's clock
  core::Duration exposure{};  ///< how long the shutter was open; 0: the camera does not tell
  core::MonoTime arrival;     ///< when the whole frame was here
  PixelFormat format = PixelFormat::kJpeg;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> bytes;
};

/// A triggered camera. Two paths share it: the simulated camera's socket (camera_socket_client.hpp)
/// and the kernel's V4L2 (v4l2_camera.hpp).
/// Trigger() may be called from the real-time thread: it never blocks and never allocates.
/// Next() belongs to one camera thread.
class Camera {
 public:
  virtual ~Camera() = default;
  /// Asks for one exposure now. `sequence` counts triggers from 1. kUnavailable while disconnected.
  /// The error message is empty here (no allocation).
  virtual core::Expected<void> Trigger(std::uint32_t sequence) = 0;
  /// Waits up to `timeout` for the next frame. Null: nothing yet ("no frame" is normal).
  /// Errors: kUnavailable when the camera is gone; the next call tries to reconnect.
  virtual core::Expected<std::shared_ptr<const Frame>> Next(core::Duration timeout) = 0;
  /// The camera that the last successful Next() read, in one line for people; may be empty. Camera
  /// thread.
  virtual std::string Description() const { return {}; }
};

}  // namespace kawara::drivers
