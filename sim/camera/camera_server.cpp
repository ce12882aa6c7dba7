#include "sim/camera/camera_server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "sim/ports/sleep_until.hpp"
#include "sim/ports/unix_listener.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kSendTimeout = core::Seconds(2);
constexpr int kPoll_ms = 20;

}  // namespace

CameraServer::CameraServer(std::filesystem::path socket, const SimClock& clock,
                           std::unique_ptr<PictureSource> pictures, const CameraOptions& options,
                           Hooks hooks)
    : socket_path_(std::move(socket)),
      faults_(std::move(hooks.faults)),
      camera_(clock, std::move(pictures), options,
              {std::move(hooks.signal), std::move(hooks.exposed)}) {}

CameraServer::~CameraServer() {
  DropClient();
  StopListening();
}

core::Expected<void> CameraServer::Listen() {
  auto fd = ListenUnix(socket_path_, "camera");
  if (!fd) return tl::unexpected(fd.error());
  listen_fd_ = *fd;
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
  camera_.Forget();
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
    const Faults faults = faults_(core::MonoNow());
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
    if (const core::MonoTime now = core::MonoNow(); camera_.WantsToPrepare(now)) {
      camera_.Prepare(now);
      WasBusySince(now);
    }
    std::array<pollfd, 2> wait{{{.fd = listen_fd_, .events = POLLIN, .revents = 0},
                                {.fd = client_fd_, .events = POLLIN, .revents = 0}}};
    if (poll(wait.data(), wait.size(), kPoll_ms) <= 0) continue;
    if (wait[0].revents != 0) Accept();
    if (wait[1].revents != 0) TakeTriggers(faults_(core::MonoNow()), stop);
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
  const core::MonoTime pulse = core::MonoTime::FromNs(message.mono_ns);
  const core::MonoTime now = core::MonoNow();
  // No camera misses a trigger because a picture is being drawn: its frame only comes later.
  const bool while_busy = pulse >= busy_from_ && pulse < busy_until_;
  const std::vector<TriggeredCamera::Frame> frames =
      camera_.OnTrigger(message.sequence, pulse, while_busy ? pulse : now, faults);
  WasBusySince(now);
  for (const TriggeredCamera::Frame& frame : frames) {
    SleepUntil(frame.ready);
    Deliver(frame, stop);
    if (frame.header.trigger_sequence == message.sequence) {
      counters_.longest_delivery = std::max(counters_.longest_delivery, core::MonoNow() - pulse);
    }
  }
}

void CameraServer::WasBusySince(core::MonoTime begin) {
  if (begin - busy_until_ > core::Milliseconds(kPoll_ms)) busy_from_ = begin;
  busy_until_ = core::MonoNow();
}

void CameraServer::Deliver(const TriggeredCamera::Frame& frame, const std::atomic<bool>& stop) {
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

CameraServer::Counters CameraServer::counters() const {
  Counters all = counters_;
  all.triggers = camera_.counters().triggers;
  all.missed = camera_.counters().missed;
  all.made_late = camera_.made_late();
  all.lost += camera_.counters().spoiled;
  return all;
}

}  // namespace kawara::sim
