#include "drivers/ntrip_client.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace kawara::drivers {
namespace {

constexpr core::Duration kFixTooOld = core::Seconds(30);

/// SplitMix64: good enough to keep a fleet from knocking in step.
std::uint64_t NextRandom(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

std::string Seconds(core::Duration d) {
  core::FixedText<32> text;
  text.Append(core::ToSeconds(d), d < core::Seconds(10) ? 1 : 0);
  return std::string(text.view()) + " s";
}

core::Error ConnectError(const std::string& who, const std::string& detail, int errno_value) {
  switch (errno_value) {
    case ENETUNREACH:
    case EHOSTUNREACH:
    case ENETDOWN:
      return {core::ErrorCode::kUnavailable, who + "no route: is the network up? (" + detail + ")"};
    case ECONNREFUSED:
      return {
          core::ErrorCode::kUnavailable,
          who + "connection refused: is the caster running, is the port right? (" + detail + ")"};
    case ETIMEDOUT:
      return {core::ErrorCode::kTimeout,
              who + "no answer to the connection request (" + detail + ")"};
    default:
      return {core::ErrorCode::kIo, who + "connection failed (" + detail + ")"};
  }
}

}  // namespace

NtripClient::NtripClient(NtripClientConfig config, core::Events& events, Output output)
    : config_(std::move(config)),
      events_(events),
      output_(std::move(output)),
      random_(config_.seed) {}

NtripClient::~NtripClient() { Close(); }

void NtripClient::OnFix(const core::GnssFix& fix) {
  if (fix.has_position && fix.rtk != core::RtkState::kNone) fix_ = fix;
}

short NtripClient::poll_events() const {
  const bool wants_out = state_ == State::kConnecting || !to_send_.empty();
  return static_cast<short>((state_ == State::kConnecting ? 0 : POLLIN) |
                            (wants_out ? POLLOUT : 0));
}

core::MonoTime NtripClient::wake_at() const {
  if (state_ == State::kPausing) return retry_at_;
  if (state_ == State::kStreaming && config_.send_position && fix_)
    return std::min(deadline_, position_at_);
  return deadline_;
}

void NtripClient::Wait(core::MonoTime now, core::Duration at_most) const {
  const core::Duration wait = std::clamp(wake_at() - now, core::Duration(0), at_most);
  pollfd entry{fd_, poll_events(), 0};
  const auto wait_ms = std::chrono::ceil<std::chrono::milliseconds>(wait).count();
  ::poll(&entry, 1,
         static_cast<int>(wait_ms));  // a negative fd is ignored: then it is a plain sleep
}

void NtripClient::Service(core::MonoTime now) {
  if (state_ == State::kPausing) {
    if (now < retry_at_) return;
    Connect(now);
  }
  if (state_ == State::kConnecting) {
    pollfd entry{fd_, POLLOUT, 0};
    if (::poll(&entry, 1, 0) > 0) {
      OnConnected(now);
    } else if (now >= deadline_) {
      connect_errors_ += (connect_errors_.empty() ? "" : ", ") + std::string("timed out after ") +
                         Seconds(config_.connect_timeout);
      TryNextAddress(now);
    }
  }
  if (state_ == State::kAsking || state_ == State::kStreaming) Receive(now);
  if (state_ == State::kStreaming && now >= position_at_) QueuePosition(now);
  if (state_ == State::kAsking || state_ == State::kStreaming) Send();
  if (state_ == State::kAsking && now >= deadline_) {
    FailWith(now, "ntrip.silent", core::Severity::kWarnLow,
             {core::ErrorCode::kTimeout,
              Caster() + "no answer to the request for " + Seconds(config_.connect_timeout)},
             false);
  } else if (state_ == State::kStreaming && now >= deadline_) {
    const bool waits_for_us = decoder_.payload_bytes() == 0 && !position_sent_;
    FailWith(
        now, "ntrip.silent", core::Severity::kWarnLow,
        {core::ErrorCode::kTimeout,
         Caster() + "silent for " + Seconds(config_.silent_timeout) +
             (waits_for_us ? ": perhaps it waits for our position, and there is no fix yet" : "")},
        false);
  }
}

void NtripClient::Connect(core::MonoTime now) {
  addresses_.clear();
  next_address_ = 0;
  connect_errors_.clear();
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(config_.caster.port);
  const int result = ::getaddrinfo(config_.caster.host.c_str(), port.c_str(), &hints, &found);
  if (result != 0) {
    const char* detail = result == EAI_SYSTEM ? std::strerror(errno) : ::gai_strerror(result);
    return FailWith(
        now, "ntrip.connect", core::Severity::kWarnLow,
        {core::ErrorCode::kNotFound,
         Caster() + "name not resolved: is the network up, is the name right? (" + detail + ")"},
        false);
  }
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    Address address;
    if (a->ai_addrlen > address.bytes.size()) continue;
    std::memcpy(address.bytes.data(), a->ai_addr, a->ai_addrlen);
    address.size = a->ai_addrlen;
    address.family = a->ai_family;
    addresses_.push_back(address);
  }
  ::freeaddrinfo(found);
  TryNextAddress(now);
}

void NtripClient::TryNextAddress(core::MonoTime now) {
  Close();
  int last_errno = ETIMEDOUT;
  while (next_address_ < addresses_.size()) {
    const Address& address = addresses_[next_address_++];
    fd_ = ::socket(address.family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd_ >= 0) {
      const auto* target = reinterpret_cast<const sockaddr*>(address.bytes.data());
      if (::connect(fd_, target, address.size) == 0 || errno == EINPROGRESS) {
        state_ = State::kConnecting;
        deadline_ = now + config_.connect_timeout;
        return;
      }
    }
    last_errno = errno;
    connect_errors_ +=
        (connect_errors_.empty() ? "" : ", ") + std::string(std::strerror(last_errno));
    Close();
  }
  FailWith(now, "ntrip.connect", core::Severity::kWarnLow,
           ConnectError(Caster(), connect_errors_, last_errno), false);
}

void NtripClient::OnConnected(core::MonoTime now) {
  int error = 0;
  socklen_t size = sizeof(error);
  if (::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = errno;
  if (error != 0) {
    connect_errors_ += (connect_errors_.empty() ? "" : ", ") + std::string(std::strerror(error));
    if (next_address_ < addresses_.size()) return TryNextAddress(now);
    return FailWith(now, "ntrip.connect", core::Severity::kWarnLow,
                    ConnectError(Caster(), connect_errors_, error), false);
  }
  ++stats_.connects;
  NtripRequest request = config_.caster;
  position_sent_ = false;
  if (config_.send_position && fix_ && now - fix_->arrival < kFixTooOld) {
    request.gga = MakeGga(*fix_).value_or("");
    position_sent_ = request.version == 2 && !request.gga.empty();
  }
  auto text = MakeNtripRequest(request);
  if (!text) return FailWith(now, "ntrip.refused", core::Severity::kWarnHigh, text.error(), true);
  to_send_ = std::move(*text);
  decoder_ = NtripDecoder(config_.caster.mountpoint.empty());
  state_ = State::kAsking;
  deadline_ = now + config_.connect_timeout;
}

void NtripClient::Send() {
  while (!to_send_.empty()) {
    const ssize_t n = ::send(fd_, to_send_.data(), to_send_.size(), MSG_NOSIGNAL);
    if (n <= 0) return;  // later, or Receive() will see what is wrong
    to_send_.erase(0, static_cast<std::size_t>(n));
  }
}

void NtripClient::Receive(core::MonoTime now) {
  std::array<std::uint8_t, 8192> buffer;
  constexpr int kMaxReads = 16;  // a caster that floods us must not keep the thread
  for (int i = 0; i < kMaxReads; ++i) {
    const ssize_t n = ::recv(fd_, buffer.data(), buffer.size(), 0);
    if (n < 0 && (errno == EAGAIN)) return;
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      return FailWith(now, "ntrip.ended", core::Severity::kWarnLow,
                      core::ErrnoError(Caster() + "connection lost", error), false);
    }
    if (n == 0) decoder_.OnClosed();
    std::span<const std::uint8_t> bytes(buffer.data(), static_cast<std::size_t>(n));
    while (const auto payload = decoder_.Next(bytes)) {
      stats_.bytes += payload->size();
      if (output_) output_(now, *payload);
    }
    const NtripState answer = decoder_.state();
    if (answer == NtripState::kDone) {
      const NtripFailure f = decoder_.failure();
      const bool transient = f == NtripFailure::kEnded || f == NtripFailure::kBrokenChunk ||
                             f == NtripFailure::kServerError || f == NtripFailure::kMountpointInUse;
      if (f == NtripFailure::kNone) {
        return FailWith(
            now, "ntrip.refused", core::Severity::kWarnHigh,
            {core::ErrorCode::kInvalidArgument, Caster() + "no mountpoint configured; it offers " +
                                                    ListMountpoints(decoder_.sources(), 120)},
            true);
      }
      return FailWith(now, transient ? "ntrip.ended" : "ntrip.refused",
                      transient ? core::Severity::kWarnLow : core::Severity::kWarnHigh,
                      decoder_.Explain(config_.caster), !transient);
    }
    if (answer == NtripState::kSourcetable)
      deadline_ = now + config_.connect_timeout;  // long, but it comes
    if (answer == NtripState::kStreaming) {
      if (state_ == State::kAsking) {
        state_ = State::kStreaming;
        ++stats_.streams;
        stream_since_ = now;
        position_at_ = now + (position_sent_ ? config_.position_period : core::Duration(0));
        events_.Info(
            now, "ntrip.streaming",
            core::EventText(std::string_view(Caster() + "streaming " + config_.caster.mountpoint)));
      }
      deadline_ = now + config_.silent_timeout;
    }
  }
}

void NtripClient::QueuePosition(core::MonoTime now) {
  position_at_ = now + core::Seconds(1);  // look again soon, unless one is sent now
  if (!config_.send_position || !fix_ || now - fix_->arrival >= kFixTooOld) return;
  if (to_send_.size() > 512) return;  // the caster does not read: no use in piling up old positions
  const auto gga = MakeGga(*fix_);
  if (!gga) return;
  to_send_ += *gga + "\r\n";
  position_at_ = now + config_.position_period;
  position_sent_ = true;
  ++stats_.positions_sent;
}

void NtripClient::FailWith(core::MonoTime now, const char* event, core::Severity severity,
                           const core::Error& error, bool refused) {
  if (state_ == State::kStreaming && now - stream_since_ >= config_.steady_after)
    failures_in_a_row_ = 0;
  Close();
  ++stats_.failures;
  core::Duration pause = config_.backoff_first;
  for (unsigned i = 0; i < failures_in_a_row_ && pause < config_.backoff_max; ++i) pause *= 2;
  pause = std::min(pause, config_.backoff_max);
  if (refused) pause = std::max(pause, config_.backoff_refused);
  ++failures_in_a_row_;
  const double jitter = 0.75 + 0.5 * static_cast<double>(NextRandom(random_) >> 11) * 0x1p-53;
  pause = core::DurationFromSeconds(core::ToSeconds(pause) * jitter);
  state_ = State::kPausing;
  retry_at_ = now + pause;
  last_error_ = error.message;
  const std::string line = last_error_ + "; next try in " + Seconds(pause);
  events_.Push(now, severity, event, core::EventText(std::string_view(line)));
}

void NtripClient::Close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  to_send_.clear();
}

std::string NtripClient::Caster() const {
  return "ntrip " + config_.caster.host + ":" + std::to_string(config_.caster.port) + ": ";
}

}  // namespace kawara::drivers
