#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

/// One open video node: the system calls the V4L2 driver makes, and no more. Here the tests put a
/// scripted camera in the kernel's place. Time comes through it as well, so that deadlines can be
/// tested without waiting. One thread, except Ioctl(), which the kernel serialises.
class V4l2Node {
 public:
  enum class Ready : std::uint8_t { kFrame, kNothing, kError };

  virtual ~V4l2Node() = default;
  /// 0, or errno. Interrupted calls are repeated inside.
  virtual int Ioctl(unsigned long request, void* argument) = 0;
  /// Memory of one buffer, by the offset VIDIOC_QUERYBUF gave. Empty: refused.
  virtual std::span<std::uint8_t> Map(std::size_t length, std::uint32_t offset) = 0;
  virtual void Unmap(std::span<std::uint8_t> memory) = 0;
  /// Waits until a frame can be dequeued. kError: the stream has ended or the device is gone; the
  /// next VIDIOC_DQBUF says which.
  virtual Ready Wait(core::Duration timeout) = 0;
  virtual core::MonoTime Now() const = 0;
};

/// Opens a node by path. kNotFound, kPermission, kUnavailable (busy), kInvalidArgument (no
/// character device): each with what to do about it.
using V4l2Opener = std::function<core::Expected<std::unique_ptr<V4l2Node>>(const std::string&)>;

/// The kernel's.
core::Expected<std::unique_ptr<V4l2Node>> OpenV4l2Node(const std::string& path);

/// An ioctl's request as people know it: "VIDIOC_S_FMT"; hexadecimal for what this driver does not
/// use.
std::string V4l2RequestName(unsigned long request);
/// "/dev/video0: VIDIOC_S_FMT: Device or resource busy", with a cure where errno tells one. ENODEV,
/// ENXIO and EIO are kUnavailable: the device went away or does not answer.
core::Error V4l2Error(const std::string& path, unsigned long request, int errno_value);

}  // namespace kawara::drivers
