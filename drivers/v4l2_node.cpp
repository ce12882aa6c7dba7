#include "drivers/v4l2_node.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace kawara::drivers {
namespace {

class KernelNode final : public V4l2Node {
 public:
  explicit KernelNode(int fd) : fd_(fd) {}
  ~KernelNode() override { close(fd_); }
  KernelNode(const KernelNode&) = delete;
  KernelNode& operator=(const KernelNode&) = delete;

  int Ioctl(unsigned long request, void* argument) override {
    for (;;) {
      if (ioctl(fd_, request, argument) == 0) return 0;
      if (errno != EINTR) return errno;
    }
  }
  std::span<std::uint8_t> Map(std::size_t length, std::uint32_t offset) override {
    void* const memory = mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, offset);
    if (memory == MAP_FAILED) return {};
    return {static_cast<std::uint8_t*>(memory), length};
  }
  void Unmap(std::span<std::uint8_t> memory) override { munmap(memory.data(), memory.size()); }
  Ready Wait(core::Duration timeout) override {
    pollfd wait{.fd = fd_, .events = POLLIN, .revents = 0};
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
    const int ready = poll(&wait, 1, static_cast<int>(std::clamp<std::int64_t>(ms, 0, 60'000)));
    if (ready <= 0) return Ready::kNothing;  // an interruption, too: the caller has a deadline
    return (wait.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 ? Ready::kError : Ready::kFrame;
  }
  core::MonoTime Now() const override { return core::MonoNow(); }

 private:
  int fd_;
};

constexpr std::array<std::pair<unsigned long, const char*>, 24> kRequests{{
    {VIDIOC_QUERYCAP, "VIDIOC_QUERYCAP"},
    {VIDIOC_ENUM_FMT, "VIDIOC_ENUM_FMT"},
    {VIDIOC_ENUM_FRAMESIZES, "VIDIOC_ENUM_FRAMESIZES"},
    {VIDIOC_ENUM_FRAMEINTERVALS, "VIDIOC_ENUM_FRAMEINTERVALS"},
    {VIDIOC_G_FMT, "VIDIOC_G_FMT"},
    {VIDIOC_S_FMT, "VIDIOC_S_FMT"},
    {VIDIOC_G_PARM, "VIDIOC_G_PARM"},
    {VIDIOC_S_PARM, "VIDIOC_S_PARM"},
    {VIDIOC_REQBUFS, "VIDIOC_REQBUFS"},
    {VIDIOC_QUERYBUF, "VIDIOC_QUERYBUF"},
    {VIDIOC_QBUF, "VIDIOC_QBUF"},
    {VIDIOC_DQBUF, "VIDIOC_DQBUF"},
    {VIDIOC_STREAMON, "VIDIOC_STREAMON"},
    {VIDIOC_STREAMOFF, "VIDIOC_STREAMOFF"},
    {VIDIOC_QUERYCTRL, "VIDIOC_QUERYCTRL"},
    {VIDIOC_QUERY_EXT_CTRL, "VIDIOC_QUERY_EXT_CTRL"},
    {VIDIOC_QUERYMENU, "VIDIOC_QUERYMENU"},
    {VIDIOC_G_CTRL, "VIDIOC_G_CTRL"},
    {VIDIOC_S_CTRL, "VIDIOC_S_CTRL"},
    {VIDIOC_G_EXT_CTRLS, "VIDIOC_G_EXT_CTRLS"},
    {VIDIOC_S_EXT_CTRLS, "VIDIOC_S_EXT_CTRLS"},
    {VIDIOC_ENUMINPUT, "VIDIOC_ENUMINPUT"},
    {VIDIOC_G_INPUT, "VIDIOC_G_INPUT"},
    {VIDIOC_S_INPUT, "VIDIOC_S_INPUT"},
}};

const char* CureOfOpen(int errno_value) {
  switch (errno_value) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return " (plugged in? `kawara-camera list` shows what is there)";
    case EACCES:
    case EPERM:
      return " (is the user in the group video? usermod -aG video NAME, then log in anew)";
    case EBUSY:
      return " (another program has it: fuser -v PATH)";
    default:
      return "";
  }
}

tl::unexpected<core::Error> NotADevice(const std::string& path) {
  return core::Fail(
      core::ErrorCode::kInvalidArgument,
      "camera " + path + ": not a device (expected /dev/videoN or a link of /dev/v4l/by-id)");
}

}  // namespace

core::Expected<std::unique_ptr<V4l2Node>> OpenV4l2Node(const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    const int reason = errno;
    if (reason == EISDIR) return NotADevice(path);
    core::Error error = core::ErrnoError("camera " + path, reason);
    error.message += CureOfOpen(reason);
    return tl::unexpected(std::move(error));
  }
  struct stat status {};
  if (fstat(fd, &status) != 0 || !S_ISCHR(status.st_mode)) {
    close(fd);
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "camera " + path + ": not a device (expected /dev/videoN or a link of /dev/v4l/by-id)");
  }
  return std::make_unique<KernelNode>(fd);
}

std::string V4l2RequestName(unsigned long request) {
  for (const auto& [number, name] : kRequests) {
    if (number == request) return name;
  }
  char text[32];
  std::snprintf(text, sizeof text, "ioctl 0x%lx", request);
  return text;
}

core::Error V4l2Error(const std::string& path, unsigned long request, int errno_value) {
  core::Error error =
      core::ErrnoError("camera " + path + ": " + V4l2RequestName(request), errno_value);
  switch (errno_value) {
    case EBUSY:
      error.message += " (another program streams from it: fuser -v PATH)";
      break;
    case ENODEV:
    case ENXIO:
      error.code = core::ErrorCode::kUnavailable;
      error.message += " (unplugged?)";
      break;
    case EIO:
    case EPROTO:
      error.code = core::ErrorCode::kUnavailable;
      error.message += " (the camera does not answer: cable, power, hub?)";
      break;
    case ENOSPC:
      error.code = core::ErrorCode::kUnavailable;
      error.message += " (no USB bandwidth left: another port, a smaller picture or MJPEG)";
      break;
    case ENOTTY:
      error.code = core::ErrorCode::kInvalidArgument;
      error.message += " (not a capture device of V4L2)";
      break;
    default:
      break;
  }
  return error;
}

}  // namespace kawara::drivers
