#include "sim/camera_server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <system_error>

#include "sim/dark_picture.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kStaleTrigger = core::Milliseconds(100);
constexpr core::Duration kLongestPeriod = core::Seconds(5);
constexpr core::Duration kSendTimeout = core::Seconds(2);
constexpr int kPoll_ms = 20;

void SleepUntil(core::MonoTime t) {
  const timespec until{.tv_sec = t.ns() / 1'000'000'000, .tv_nsec = t.ns() % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace

CameraServer::CameraServer(std::filesystem::path socket, const SimClock& clock,
                           std::unique_ptr<PictureSource> pictures, const CameraOptions& options,
                           Hooks hooks)
    : socket_path_(std::move(socket)),
      clock_(clock),
      pictures_(std::move(pictures)),
      options_(options),
      hooks_(std::move(hooks)),
      dice_(options.seed) {}

CameraServer::~CameraServer() {
  DropClient();
  StopListening();
}

core::Expected<void> CameraServer::Listen() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = socket_path_.string();
  if (path.size() >= sizeof address.sun_path) {
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "camera socket " + path + ": longer than 107 characters; choose a shorter --run-dir");
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  std::error_code ignored;
  if (std::filesystem::is_socket(socket_path_, ignored))
    std::filesystem::remove(socket_path_, ignored);
  listen_fd_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listen_fd_ < 0 ||
      bind(listen_fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listen_fd_, 2) != 0) {
    const core::Error error = core::ErrnoError("camera socket " + path, errno);
    if (listen_fd_ >= 0) close(listen_fd_);
    listen_fd_ = -1;
    return tl::unexpected(error);
  }
  return {};
}

void CameraServer::StopListening() {
  if (listen_fd_ < 0) return;
  close(listen_fd_);
  listen_fd_ = -1;
  std::error_code ignored;
  std::filesystem::remove(socket_path_, ignored);
}

void CameraServer::DropClient() {
  if (client_fd_ >= 0) close(client_fd_);
  client_fd_ = -1;
  message_size_ = 0;
  held_back_.reset();
}

void CameraServer::Accept() {
  const int fd = accept4(listen_fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  if (client_fd_ >= 0) {  // one camera, one user; the later one is told by an immediate end
    close(fd);
    return;
  }
  client_fd_ = fd;
  ++counters_.clients;
}

void CameraServer::Run(const std::atomic<bool>& stop) {
  while (!stop.load()) {
    const Faults faults = hooks_.faults(core::MonoNow());
    if (faults.disconnected) {
      DropClient();
      StopListening();
    } else if (listen_fd_ < 0) {
      const core::Expected<void> listening = Listen();
      if (!listening) std::fprintf(stderr, "kawara-sim: %s\n", listening.error().message.c_str());
    }
    if (faults.hang || listen_fd_ < 0) {
      SleepUntil(core::MonoNow() + core::Milliseconds(kPoll_ms));
      continue;
    }
    if (!prepared_ && core::MonoNow() >= prepare_at_) PrepareNext();
    std::array<pollfd, 2> wait{{{.fd = listen_fd_, .events = POLLIN, .revents = 0},
                                {.fd = client_fd_, .events = POLLIN, .revents = 0}}};
    if (poll(wait.data(), wait.size(), kPoll_ms) <= 0) continue;
    if (wait[0].revents != 0) Accept();
    if (wait[1].revents != 0) TakeTriggers(hooks_.faults(core::MonoNow()), stop);
  }
}

void CameraServer::TakeTriggers(const Faults& faults, const std::atomic<bool>& stop) {
  while (client_fd_ >= 0) {
    const ssize_t n = recv(client_fd_, message_.data() + message_size_,
                           message_.size() - message_size_, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n <= 0) return DropClient();
    message_size_ += static_cast<std::size_t>(n);
    if (message_size_ < message_.size()) continue;
    message_size_ = 0;
    drivers::CameraTriggerMessage message;
    std::memcpy(&message, message_.data(), sizeof message);
    if (message.magic != drivers::kCameraTriggerMagic) return DropClient();
    OnTrigger(message, faults, stop);
  }
}

void CameraServer::OnTrigger(const drivers::CameraTriggerMessage& message, const Faults& faults,
                             const std::atomic<bool>& stop) {
  ++counters_.triggers;
  const core::MonoTime now = core::MonoNow();
  const core::MonoTime pulse = std::min(core::MonoTime::FromNs(message.mono_ns), now);
  if (faults.miss || now - pulse > kStaleTrigger) {
    ++counters_.missed;
    return;
  }
  hooks_.trigger_pulse(pulse);
  period_ = last_trigger_.IsSet() ? pulse - last_trigger_ : core::Duration{};
  last_trigger_ = pulse;
  prepared_ = false;
  // A camera's own electronics cost the robot's computer nothing: the next picture is drawn when
  // the robot has most likely done with this one.
  prepare_at_ = pulse + (period_ < kLongestPeriod ? period_ / 2 : core::Duration{});

  const double delay_s = options_.exposure_delay_s + options_.exposure_jitter_s * dice_.Normal();
  const core::MonoTime start = pulse + core::DurationFromSeconds(std::max(delay_s, 0.0));
  Exposure exposure{message.sequence, ++frame_sequence_, start, clock_.GpsAt(start)};
  core::Expected<Picture> picture =
      pictures_->Expose({.trigger_sequence = message.sequence, .exposure = exposure.gps});
  if (picture && faults.dark) picture = DarkPicture(*picture);
  if (picture && picture->exposed.IsSet()) {
    exposure.gps = picture->exposed;
    exposure.mono = clock_.MonoAt(picture->exposed);
  }
  hooks_.exposed(exposure);
  std::optional<FrameOut> due = std::exchange(held_back_, std::nullopt);
  if (due) Deliver(*due, stop);
  if (!picture) {
    std::fprintf(stderr, "kawara-sim: %s\n", picture.error().message.c_str());
    ++counters_.lost;
    return;
  }
  FrameOut frame;
  frame.header.sequence = exposure.frame_sequence;
  frame.header.trigger_sequence = message.sequence;
  frame.header.exposure_start_mono_ns = exposure.mono.ns();
  frame.header.width = picture->width;
  frame.header.height = picture->height;
  frame.header.payload_bytes = static_cast<std::uint32_t>(picture->jpeg.size());
  frame.picture = std::move(*picture);
  if (faults.late) {
    held_back_ = std::move(frame);
    return;
  }
  SleepUntil(start + core::DurationFromSeconds(options_.readout_s));
  Deliver(frame, stop);
  counters_.longest_delivery = std::max(counters_.longest_delivery, core::MonoNow() - pulse);
}

void CameraServer::Deliver(const FrameOut& frame, const std::atomic<bool>& stop) {
  if (SendAll(&frame.header, sizeof frame.header, stop) &&
      SendAll(frame.picture.jpeg.data(), frame.picture.jpeg.size(), stop)) {
    ++counters_.frames;
    return;
  }
  ++counters_.lost;
  DropClient();
}

bool CameraServer::SendAll(const void* data, std::size_t size, const std::atomic<bool>& stop) {
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  const core::MonoTime deadline = core::MonoNow() + kSendTimeout;
  while (size > 0) {
    if (client_fd_ < 0 || stop.load() || core::MonoNow() > deadline) return false;
    const ssize_t n = send(client_fd_, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) {
      bytes += n;
      size -= static_cast<std::size_t>(n);
    } else if (errno == EAGAIN || errno == EINTR) {
      pollfd wait{.fd = client_fd_, .events = POLLOUT, .revents = 0};
      poll(&wait, 1, kPoll_ms);
    } else {
      return false;
    }
  }
  return true;
}

void CameraServer::PrepareNext() {
  prepared_ = true;
  const bool regular = period_.count() > 0 && period_ < kLongestPeriod;
  const core::MonoTime expected = regular ? last_trigger_ + period_ : core::MonoNow();
  pictures_->Prepare(clock_.GpsAt(expected + core::DurationFromSeconds(options_.exposure_delay_s)));
}

}  // namespace kawara::sim
