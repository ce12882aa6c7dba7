#include "drivers/camera_socket_client.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/unix_socket.hpp"

namespace kawara::drivers {
namespace {

/// First piece of memory for a payload; more only as bytes really come.
constexpr std::size_t kFirstReserve = std::size_t{1} << 16;

tl::unexpected<core::Error> BadHeader(const std::string& what) {
  return core::Fail(core::ErrorCode::kFormat, "camera frame header: " + what);
}

}  // namespace

core::Expected<CameraFrameHeader> ParseCameraFrameHeader(
    std::span<const std::uint8_t, sizeof(CameraFrameHeader)> bytes) {
  CameraFrameHeader header;
  std::memcpy(&header, bytes.data(),
              sizeof header);  // both ends are the same machine: same byte order
  if (header.magic != kCameraFrameMagic)
    return BadHeader("wrong magic (not the camera's protocol?)");
  const auto format = static_cast<PixelFormat>(header.format);
  if (format != PixelFormat::kJpeg && format != PixelFormat::kRgb8 &&
      format != PixelFormat::kGrey8) {
    return BadHeader("unknown pixel format " + std::to_string(header.format));
  }
  if (header.width == 0 || header.height == 0 || header.width > kCameraMaxSidePx ||
      header.height > kCameraMaxSidePx) {
    return BadHeader("picture of " + std::to_string(header.width) + " x " +
                     std::to_string(header.height));
  }
  if (header.payload_bytes == 0 || header.payload_bytes > kCameraMaxPayloadBytes) {
    return BadHeader("payload of " + std::to_string(header.payload_bytes) + " bytes");
  }
  const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
  if ((format == PixelFormat::kRgb8 && header.payload_bytes != 3 * pixels) ||
      (format == PixelFormat::kGrey8 && header.payload_bytes != pixels)) {
    return BadHeader("payload of " + std::to_string(header.payload_bytes) +
                     " bytes for a raw picture of " + std::to_string(header.width) + " x " +
                     std::to_string(header.height));
  }
  return header;
}

core::Expected<std::shared_ptr<const Frame>> CameraFrameAssembler::Feed(
    core::MonoTime now, std::span<const std::uint8_t>& bytes) {
  if (!frame_) {
    const std::size_t n = std::min(bytes.size(), header_bytes_.size() - header_size_);
    std::copy_n(bytes.begin(), n,
                header_bytes_.begin() + static_cast<std::ptrdiff_t>(header_size_));
    header_size_ += n;
    bytes = bytes.subspan(n);
    if (header_size_ < header_bytes_.size()) return std::shared_ptr<const Frame>();
    const core::Expected<CameraFrameHeader> header = ParseCameraFrameHeader(header_bytes_);
    if (!header) return tl::unexpected(header.error());
    frame_ = std::make_shared<Frame>();
    frame_->sequence = header->sequence;
    frame_->trigger_sequence = header->trigger_sequence;
    frame_->exposure_start = core::MonoTime::FromNs(header->exposure_start_mono_ns);
    frame_->format = static_cast<PixelFormat>(header->format);
    frame_->width = header->width;
    frame_->height = header->height;
    payload_bytes_ = header->payload_bytes;
    frame_->bytes.reserve(std::min<std::size_t>(payload_bytes_, kFirstReserve));
  }
  const std::size_t n = std::min<std::size_t>(bytes.size(), payload_bytes_ - frame_->bytes.size());
  frame_->bytes.insert(frame_->bytes.end(), bytes.begin(),
                       bytes.begin() + static_cast<std::ptrdiff_t>(n));
  bytes = bytes.subspan(n);
  if (frame_->bytes.size() < payload_bytes_) return std::shared_ptr<const Frame>();
  frame_->arrival = now;
  header_size_ = 0;
  return std::shared_ptr<const Frame>(std::exchange(frame_, nullptr));
}

void CameraFrameAssembler::Reset() {
  frame_.reset();
  header_size_ = 0;
}

SocketCamera::SocketCamera(std::string path, core::Duration stall)
    : path_(std::move(path)),
      stall_(stall),
      fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}

SocketCamera::~SocketCamera() {
  if (fd_ >= 0) close(fd_);
}

core::Expected<void> SocketCamera::Trigger(std::uint32_t sequence) {
  CameraTriggerMessage message;
  message.sequence = sequence;
  message.mono_ns = core::MonoNow().ns();
  // 16 bytes into a stream socket go in whole or not at all as long as the buffer has room for
  // them.
  if (!connected() ||
      send(fd_, &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL) != sizeof message) {
    lost_triggers_.fetch_add(1, std::memory_order_relaxed);
    return tl::unexpected(core::Error{core::ErrorCode::kUnavailable, {}});
  }
  return {};
}

core::Expected<void> SocketCamera::Connect() {
  if (fd_ < 0) {
    return core::Fail(core::ErrorCode::kUnavailable,
                      "camera socket " + path_ + ": no descriptor was left at the start");
  }
  const auto fresh = ConnectUnix(path_, "camera socket", "the camera's program");
  if (!fresh) return tl::unexpected(fresh.error());
  dup3(*fresh, fd_, O_CLOEXEC);
  close(*fresh);
  assembler_.Reset();
  buffer_begin_ = buffer_end_ = 0;
  last_bytes_ = core::MonoTime{};
  ++stats_.connects;
  connected_.store(true, std::memory_order_release);
  return {};
}

core::Expected<std::shared_ptr<const Frame>> SocketCamera::Lose(core::Error why) {
  connected_.store(false, std::memory_order_release);
  shutdown(fd_, SHUT_RDWR);
  ++stats_.disconnects;
  return tl::unexpected(std::move(why));
}

core::Expected<std::shared_ptr<const Frame>> SocketCamera::Next(core::Duration timeout) {
  if (!connected()) {
    const core::Expected<void> connection = Connect();
    if (!connection) return tl::unexpected(connection.error());
  }
  const core::MonoTime deadline = core::MonoNow() + timeout;
  for (;;) {
    if (buffer_begin_ < buffer_end_) {
      std::span<const std::uint8_t> rest(buffer_.data() + buffer_begin_,
                                         buffer_end_ - buffer_begin_);
      core::Expected<std::shared_ptr<const Frame>> frame = assembler_.Feed(core::MonoNow(), rest);
      buffer_begin_ = buffer_end_ - rest.size();
      if (!frame) {
        ++stats_.format_errors;
        return Lose(frame.error());
      }
      if (*frame) {
        last_bytes_ = core::MonoTime{};
        ++stats_.frames;
        return frame;
      }
    }
    const core::MonoTime now = core::MonoNow();
    if (last_bytes_.IsSet() && now - last_bytes_ > stall_) {
      return Lose(
          {core::ErrorCode::kUnavailable, "camera " + path_ + ": a frame stopped half-way"});
    }
    const auto left_ms = std::max<std::int64_t>(
        (deadline - now + core::Nanoseconds(999'999)).count() / 1'000'000, 0);
    pollfd wait{.fd = fd_, .events = POLLIN, .revents = 0};
    const int ready = poll(&wait, 1, static_cast<int>(std::min<std::int64_t>(left_ms, 60'000)));
    if (ready == 0 || (ready < 0 && errno == EINTR)) {
      if (core::MonoNow() >= deadline) return std::shared_ptr<const Frame>();
      continue;
    }
    const ssize_t n = ready > 0 ? recv(fd_, buffer_.data(), buffer_.size(), MSG_DONTWAIT) : -1;
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (n <= 0)
      return Lose({core::ErrorCode::kUnavailable, "camera " + path_ + ": connection closed"});
    buffer_begin_ = 0;
    buffer_end_ = static_cast<std::size_t>(n);
    last_bytes_ = core::MonoNow();
  }
}

}  // namespace kawara::drivers
