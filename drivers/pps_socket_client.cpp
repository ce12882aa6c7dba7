#include "drivers/pps_socket_client.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/unix_socket.hpp"

namespace kawara::drivers {

core::Expected<PpsEdge> ParsePpsEdge(std::span<const std::uint8_t, sizeof(PpsEdgeMessage)> bytes,
                                     core::MonoTime now) {
  PpsEdgeMessage message;
  std::memcpy(&message, bytes.data(), sizeof message);  // one machine: same byte order
  if (message.magic != kPpsEdgeMagic) {
    return core::Fail(core::ErrorCode::kFormat,
                      "pulse: wrong magic (not the protocol of a pulse line?)");
  }
  if (message.mono_ns <= 0 || message.mono_ns > (now + kPpsFuture).ns()) {
    return core::Fail(core::ErrorCode::kFormat,
                      "pulse: stamped " + std::to_string(message.mono_ns) +
                          " ns, which is not a past instant of this machine's clock");
  }
  return PpsEdge{message.sequence, core::MonoTime::FromNs(message.mono_ns)};
}

core::Expected<std::optional<PpsEdge>> PpsEdgeAssembler::Feed(
    core::MonoTime now, std::span<const std::uint8_t>& bytes) {
  const std::size_t n = std::min(bytes.size(), record_.size() - size_);
  std::copy_n(bytes.begin(), n, record_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += n;
  bytes = bytes.subspan(n);
  if (size_ < record_.size()) return std::nullopt;
  size_ = 0;
  return ParsePpsEdge(record_, now).map([](const PpsEdge& edge) { return std::optional(edge); });
}

SocketPps::~SocketPps() {
  if (fd_ >= 0) close(fd_);
}

core::Expected<void> SocketPps::Connect() {
  const auto fresh = ConnectUnix(path_, "pulse socket", "the program that stamps the pulses");
  if (!fresh) return tl::unexpected(fresh.error());
  fd_ = *fresh;
  assembler_.Reset();
  rest_ = {};
  ++stats_.connects;
  return {};
}

tl::unexpected<core::Error> SocketPps::Lose(core::Error why) {
  close(std::exchange(fd_, -1));
  ++stats_.disconnects;
  return tl::unexpected(std::move(why));
}

core::Expected<std::optional<PpsEdge>> SocketPps::TakeBuffered() {
  while (!rest_.empty()) {
    const core::MonoTime now = core::MonoNow();
    auto edge = assembler_.Feed(now, rest_);
    if (!edge) {
      ++stats_.format_errors;
      return Lose(std::move(edge.error()));
    }
    if (!*edge) continue;
    if (now - (*edge)->mono <= kStale) {
      ++stats_.edges;
      return edge;
    }
    ++stats_.stale;
  }
  return std::nullopt;
}

core::Expected<std::optional<PpsEdge>> SocketPps::Next(core::Duration timeout) {
  if (fd_ < 0) {
    if (auto connected = Connect(); !connected) return tl::unexpected(connected.error());
  }
  const core::MonoTime deadline = core::MonoNow() + timeout;
  for (;;) {
    auto edge = TakeBuffered();
    if (!edge || *edge) return edge;
    const core::Duration left = deadline - core::MonoNow();
    const auto left_ms = std::clamp<std::int64_t>(left.count() / 1'000'000 + 1, 0, 60'000);
    pollfd wait{.fd = fd_, .events = POLLIN, .revents = 0};
    const int ready = left.count() > 0 ? poll(&wait, 1, static_cast<int>(left_ms)) : 0;
    if (ready <= 0) {
      if (core::MonoNow() >= deadline) return std::nullopt;
      continue;
    }
    const ssize_t n = recv(fd_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (n <= 0) {
      return Lose({core::ErrorCode::kUnavailable, "pulse socket " + path_ + ": connection closed"});
    }
    rest_ = std::span<const std::uint8_t>(buffer_).first(static_cast<std::size_t>(n));
  }
}

}  // namespace kawara::drivers
