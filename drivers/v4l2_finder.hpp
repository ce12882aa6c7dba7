#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "drivers/v4l2_device.hpp"

namespace kawara::drivers {

/// /dev/video0, /dev/video1, ... of this machine, by number.
std::vector<std::string> ListVideoNodes();
/// The links of /dev/v4l/by-id and by-path that point to this node, sorted.
std::vector<std::string> StableNames(const std::string& node);

/// Finds a camera, and finds the same one again after it was unplugged, whatever number it has
/// then. `device` is a path (a node, or a link of /dev/v4l/by-id, followed anew each time), or else
/// what the camera says of itself: its bus ("usb-0000:00:14.0-1") or its name ("HD Pro Webcam
/// C920"). One thread.
class V4l2Finder {
 public:
  using Lister = std::function<std::vector<std::string>()>;
  V4l2Finder(std::string device, V4l2Opener opener, Lister nodes = ListVideoNodes);

  /// Open and a capture device. The first time: what `device` says. Later: the camera of the first
  /// time, looked for at its path and then at all nodes by bus and name; another camera at the path
  /// is only taken if it is of the same name (the same one in another socket).
  /// Errors: of the path as OpenV4l2Node and V4l2Device::Take give them; kUnavailable: nothing of
  /// that name, or another camera is in its place.
  core::Expected<V4l2Device> Find();

 private:
  core::Expected<V4l2Device> Open(const std::string& path) const;
  core::Expected<V4l2Device> ByPath();
  core::Expected<V4l2Device> ByIdentity();
  std::optional<V4l2Device> Search(const std::function<bool(const V4l2Identity&)>& fits) const;

  std::string device_;
  V4l2Opener opener_;
  Lister nodes_;
  std::optional<V4l2Identity> known_;
};

}  // namespace kawara::drivers
