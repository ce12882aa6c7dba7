#include "drivers/v4l2_stream.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

namespace kawara::drivers {
namespace {

/// A buffer's description for an ioctl: one plane, whichever of the two interfaces.
struct BufferArgument {
  v4l2_buffer buffer{};
  v4l2_plane plane{};

  BufferArgument(const V4l2Device& device, std::uint32_t index) {
    buffer.type = device.buffer_type();
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    if (device.multiplanar()) {
      buffer.m.planes = &plane;
      buffer.length = 1;
    }
  }
  BufferArgument(const BufferArgument&) = delete;
  BufferArgument& operator=(const BufferArgument&) = delete;
};

}  // namespace

core::Expected<V4l2Stream> V4l2Stream::Start(V4l2Device& device) {
  V4l2Stream stream(device);
  if (auto done = stream.Allocate(); !done) return tl::unexpected(done.error());
  if (auto done = stream.SwitchOn(); !done) return tl::unexpected(done.error());
  return stream;
}

V4l2Stream::V4l2Stream(V4l2Stream&& other) noexcept
    : device_(std::exchange(other.device_, nullptr)), memory_(std::exchange(other.memory_, {})) {}

V4l2Stream::~V4l2Stream() {
  if (device_ == nullptr) return;
  V4l2Node& node = device_->node();
  std::uint32_t type = device_->buffer_type();
  (void)node.Ioctl(VIDIOC_STREAMOFF, &type);
  for (const std::span<std::uint8_t> memory : memory_) node.Unmap(memory);
  v4l2_requestbuffers none{};
  none.type = type;
  none.memory = V4L2_MEMORY_MMAP;
  (void)node.Ioctl(VIDIOC_REQBUFS, &none);
}

core::Expected<void> V4l2Stream::Allocate() {
  V4l2Node& node = device_->node();
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = device_->buffer_type();
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = node.Ioctl(VIDIOC_REQBUFS, &request); error != 0) {
    return tl::unexpected(device_->Error(VIDIOC_REQBUFS, error));
  }
  if (request.count < kMinBuffers) {
    return core::Fail(core::ErrorCode::kFull,
                      "camera " + device_->path() + ": the kernel has memory for only " +
                          std::to_string(request.count) + " pictures (choose a smaller one)");
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    BufferArgument query(*device_, i);
    if (const int error = node.Ioctl(VIDIOC_QUERYBUF, &query.buffer); error != 0) {
      return tl::unexpected(device_->Error(VIDIOC_QUERYBUF, error));
    }
    const bool planes = device_->multiplanar();
    const std::size_t length = planes ? query.plane.length : query.buffer.length;
    const std::uint32_t offset = planes ? query.plane.m.mem_offset : query.buffer.m.offset;
    const auto memory = node.Map(length, offset);
    if (memory.empty()) {
      return core::Fail(core::ErrorCode::kFull, "camera " + device_->path() + ": a buffer of " +
                                                    std::to_string(length) +
                                                    " bytes could not be mapped");
    }
    memory_.push_back(memory);
  }
  return {};
}

core::Expected<void> V4l2Stream::SwitchOn() {
  for (std::uint32_t i = 0; i < memory_.size(); ++i) {
    if (auto queued = Queue(i); !queued) return queued;
  }
  std::uint32_t type = device_->buffer_type();
  if (const int error = device_->node().Ioctl(VIDIOC_STREAMON, &type); error != 0) {
    return tl::unexpected(device_->Error(VIDIOC_STREAMON, error));
  }
  return {};
}

core::Expected<void> V4l2Stream::Queue(std::uint32_t index) {
  BufferArgument queue(*device_, index);
  if (const int error = device_->node().Ioctl(VIDIOC_QBUF, &queue.buffer); error != 0) {
    return tl::unexpected(device_->Error(VIDIOC_QBUF, error));
  }
  return {};
}

core::Expected<V4l2Stream::Got> V4l2Stream::Take(core::Duration timeout, V4l2Loan& loan) {
  V4l2Node& node = device_->node();
  if (node.Wait(timeout) == V4l2Node::Ready::kNothing) return Got::kNothing;
  BufferArgument filled(*device_, 0);
  if (const int error = node.Ioctl(VIDIOC_DQBUF, &filled.buffer); error != 0) {
    if (error == EAGAIN) return Got::kNothing;
    return tl::unexpected(device_->Error(VIDIOC_DQBUF, error));
  }
  const v4l2_buffer& buffer = filled.buffer;
  if (buffer.index >= memory_.size()) {
    return core::Fail(core::ErrorCode::kFormat, "camera " + device_->path() +
                                                    ": the kernel gave back buffer " +
                                                    std::to_string(buffer.index) + ", not ours");
  }
  const std::span<const std::uint8_t> memory = memory_[buffer.index];
  std::size_t begin = 0, used = buffer.bytesused;
  if (device_->multiplanar()) {
    begin = std::min<std::size_t>(filled.plane.data_offset, memory.size());
    used = filled.plane.bytesused - std::min(filled.plane.bytesused, filled.plane.data_offset);
  }
  loan.index = buffer.index;
  loan.bytes = memory.subspan(begin, std::min(used, memory.size() - begin));
  loan.sequence = buffer.sequence;
  loan.flags = buffer.flags;
  loan.stamp_s = buffer.timestamp.tv_sec;
  loan.stamp_us = buffer.timestamp.tv_usec;
  loan.arrival = node.Now();
  return Got::kFrame;
}

core::Expected<void> V4l2Stream::GiveBack(const V4l2Loan& loan) { return Queue(loan.index); }

core::Expected<void> V4l2Stream::Restart() {
  std::uint32_t type = device_->buffer_type();
  if (const int error = device_->node().Ioctl(VIDIOC_STREAMOFF, &type); error != 0) {
    return tl::unexpected(device_->Error(VIDIOC_STREAMOFF, error));
  }
  return SwitchOn();
}

}  // namespace kawara::drivers
