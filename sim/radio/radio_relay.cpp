#include "sim/radio/radio_relay.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <deque>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace kawara::sim {
namespace {

constexpr std::size_t kLargestDatagram = 65536;
constexpr int kReceiveBufferBytes = 4 << 20;  // a picture's fragments come all at once
constexpr std::size_t kMaxSenders = 64;       // sockets a side; the first to have come goes first
constexpr int kMostAtOnce = 256;              // then what is due goes out
constexpr core::Duration kLongestSleep = core::Milliseconds(50);

// The sockets API takes every address as sockaddr*.
sockaddr* Generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

core::Error MulticastError(const std::string& what) {
  core::Error error = core::ErrnoError(what, errno);
  error.message +=
      "; inside this machine LCM needs, as root: ip link set lo up multicast on && "
      "ip route replace 224.0.0.0/4 dev lo";
  return error;
}

class Socket {
 public:
  Socket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  Socket& operator=(Socket&&) = delete;
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

struct Sender {
  std::uint32_t address = 0;  ///< network order, as received
  std::uint16_t port = 0;
  auto operator<=>(const Sender&) const = default;
};

/// What hears a bus and speaks on it.
class Station {
 public:
  explicit Station(const RadioSide& side) : side_(side) {
    group_.sin_family = AF_INET;
    group_.sin_addr = side.group;
    group_.sin_port = htons(side.port);
  }
  core::Expected<void> Open(const std::string& url) {
    const int yes = 1;
    ip_mreq membership{};
    membership.imr_multiaddr = side_.group;
    membership.imr_interface.s_addr = htonl(INADDR_ANY);  // as LCM does
    sockaddr_in local = group_;                           // hears this group only
    // Root gets what it asks for, others what the kernel allows.
    for (const int option : {SO_RCVBUF, SO_RCVBUFFORCE}) {
      ::setsockopt(ear_.fd(), SOL_SOCKET, option, &kReceiveBufferBytes, sizeof kReceiveBufferBytes);
    }
    if (::setsockopt(ear_.fd(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        ::setsockopt(ear_.fd(), SOL_SOCKET, SO_REUSEPORT, &yes, sizeof yes) != 0 ||
        ::bind(ear_.fd(), Generic(local), sizeof local) != 0 ||
        ::setsockopt(ear_.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) !=
            0) {
      return tl::unexpected(MulticastError("radio: cannot hear " + url));
    }
    return {};
  }
  int fd() const { return ear_.fd(); }

  /// The next datagram that somebody else sent. False: there is none.
  bool Hear(std::vector<std::uint8_t>& bytes, Sender& from) {
    while (true) {
      sockaddr_in source{};
      socklen_t length = sizeof source;
      bytes.resize(kLargestDatagram);
      const ssize_t got =
          ::recvfrom(ear_.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT, Generic(source), &length);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return false;
      if (own_ports_.contains(source.sin_port)) continue;  // our own voice
      bytes.resize(static_cast<std::size_t>(got));
      from = {source.sin_addr.s_addr, source.sin_port};
      return true;
    }
  }

  /// Speaks for a sender of the other side. What the network does not take is lost, as on any UDP.
  void Speak(const Sender& sender, const std::vector<std::uint8_t>& bytes) {
    const auto known = mouths_.find(sender);
    const int fd = known != mouths_.end() ? known->second.fd() : NewMouth(sender);
    if (fd < 0) return;
    [[maybe_unused]] const ssize_t sent =
        ::sendto(fd, bytes.data(), bytes.size(), 0, Generic(group_), sizeof group_);
  }

 private:
  int NewMouth(const Sender& sender) {
    if (order_.size() >= kMaxSenders) {
      mouths_.erase(order_.front());
      order_.pop_front();
    }
    Socket socket;
    sockaddr_in local{};
    local.sin_family = AF_INET;
    socklen_t length = sizeof local;
    const auto ttl = static_cast<unsigned char>(side_.ttl);
    if (::bind(socket.fd(), Generic(local), sizeof local) != 0 ||
        ::getsockname(socket.fd(), Generic(local), &length) != 0 ||
        ::setsockopt(socket.fd(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0) {
      return -1;
    }
    own_ports_.insert(local.sin_port);
    order_.push_back(sender);
    return mouths_.emplace(sender, std::move(socket)).first->second.fd();
  }

  RadioSide side_;
  sockaddr_in group_{};
  Socket ear_;
  std::map<Sender, Socket> mouths_;
  std::deque<Sender> order_;
  /// Network order; never forgotten, as the kernel gives out the same number late.
  std::set<std::uint16_t> own_ports_;
};

/// One way across: from a station's ear to the other's mouths.
class Way {
 public:
  Way(Station& from, Station& to, const RadioOptions& options, std::uint64_t seed)
      : from_(from), to_(to), channel_(options, seed) {}

  void TakeIn(const std::function<RadioFaults(core::MonoTime)>& faults) {
    Sender sender;
    for (int n = 0; n < kMostAtOnce && from_.Hear(buffer_, sender); ++n) {
      const core::MonoTime now = core::MonoNow();
      if (const auto due = channel_.Offer(now, buffer_.size(), faults(now))) {
        in_air_.push_back({*due, sender, buffer_});
      }
    }
  }
  void GiveOut() {
    while (!in_air_.empty() && in_air_.front().due <= core::MonoNow()) {
      to_.Speak(in_air_.front().sender, in_air_.front().bytes);
      in_air_.pop_front();
    }
  }
  core::MonoTime NextDue(core::MonoTime latest) const {
    return in_air_.empty() ? latest : std::min(latest, in_air_.front().due);
  }
  const RadioChannel::Counters& counters() const { return channel_.counters(); }

 private:
  struct Datagram {
    core::MonoTime due;
    Sender sender;
    std::vector<std::uint8_t> bytes;
  };
  Station& from_;
  Station& to_;
  RadioChannel channel_;
  std::vector<std::uint8_t> buffer_;
  std::deque<Datagram> in_air_;  ///< in order of arrival, which the channel keeps
};

std::string WayText(const RadioChannel::Counters& c) {
  std::array<char, 240> text{};
  std::snprintf(
      text.data(), text.size(),
      "%llu datagrams (%llu packets, %.1f MB) in, %llu delivered; lost: %llu for single "
      "packets, %llu in fades, %llu while down, %llu for a full queue",
      static_cast<unsigned long long>(c.offered), static_cast<unsigned long long>(c.packets),
      static_cast<double>(c.offered_bytes) * 1e-6, static_cast<unsigned long long>(c.delivered),
      static_cast<unsigned long long>(c.lost), static_cast<unsigned long long>(c.lost_in_bursts),
      static_cast<unsigned long long>(c.lost_while_down),
      static_cast<unsigned long long>(c.dropped));
  return text.data();
}

bool ReadNumber(std::string_view text, int low, int high, int& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number >= low &&
         number <= high;
}

}  // namespace

core::Expected<RadioSide> ParseRadioSide(const std::string& url) {
  const auto wrong = [&url](const char* what) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "radio: '" + url + "' " + what +
                          "; expected a bus as LCM writes it: udpm://239.255.76.67:7667?ttl=0");
  };
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) return wrong("does not begin with udpm://");
  const std::string_view all = std::string_view(url).substr(kScheme.size());
  const std::size_t question = std::min(all.find('?'), all.size());
  const std::string_view place = all.substr(0, question);
  const std::size_t colon = place.find(':');
  if (colon == std::string_view::npos) return wrong("has no port");
  RadioSide side;
  int port = 0;
  if (::inet_pton(AF_INET, std::string(place.substr(0, colon)).c_str(), &side.group) != 1 ||
      !IN_MULTICAST(ntohl(side.group.s_addr))) {
    return wrong("has no multicast address");
  }
  if (!ReadNumber(place.substr(colon + 1), 1, 65535, port)) return wrong("has a wrong port");
  side.port = static_cast<std::uint16_t>(port);
  constexpr std::string_view kTtl = "ttl=";
  std::string_view rest = question < all.size() ? all.substr(question + 1) : std::string_view{};
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view word = rest.substr(0, end);
    if (word.starts_with(kTtl) && !ReadNumber(word.substr(kTtl.size()), 0, 255, side.ttl))
      return wrong("has a wrong ttl");
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return side;
}

std::string RadioSummary::ToText() const {
  return "robot to base " + WayText(down) + "; base to robot " + WayText(up);
}

struct RadioRelay::Impl {
  Impl(const RadioSide& robot_side, const RadioSide& base_side, const RadioRelayOptions& options)
      : robot(robot_side),
        base(base_side),
        down(robot, base, options.down, options.seed),
        up(base, robot, options.up, options.seed + 1) {}
  Station robot;
  Station base;
  Way down;
  Way up;
};

RadioRelay::RadioRelay(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RadioRelay::~RadioRelay() = default;

core::Expected<std::unique_ptr<RadioRelay>> RadioRelay::Open(const RadioRelayOptions& options) {
  const auto robot = ParseRadioSide(options.robot_url);
  if (!robot) return tl::unexpected(robot.error());
  const auto base = ParseRadioSide(options.base_url);
  if (!base) return tl::unexpected(base.error());
  if (robot->group.s_addr == base->group.s_addr && robot->port == base->port) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "radio: robot and base are on the same bus (" + options.robot_url +
                          "): nothing to carry; give one of them another port");
  }
  auto impl = std::make_unique<Impl>(*robot, *base, options);
  if (auto open = impl->robot.Open(options.robot_url); !open) return tl::unexpected(open.error());
  if (auto open = impl->base.Open(options.base_url); !open) return tl::unexpected(open.error());
  return std::unique_ptr<RadioRelay>(new RadioRelay(std::move(impl)));
}

RadioSummary RadioRelay::Run(const std::function<RadioFaults(core::MonoTime)>& faults,
                             core::MonoTime end, const std::atomic<bool>& stop) {
  std::array<pollfd, 2> ears{{{impl_->robot.fd(), POLLIN, 0}, {impl_->base.fd(), POLLIN, 0}}};
  while (!stop.load() && !(end.IsSet() && core::MonoNow() >= end)) {
    impl_->down.GiveOut();
    impl_->up.GiveOut();
    const core::MonoTime now = core::MonoNow();
    const core::MonoTime wake = impl_->up.NextDue(impl_->down.NextDue(now + kLongestSleep));
    const std::int64_t wait_ns = std::max<std::int64_t>((wake - now).count(), 0);
    const timespec wait{.tv_sec = wait_ns / 1'000'000'000, .tv_nsec = wait_ns % 1'000'000'000};
    ::ppoll(ears.data(), ears.size(), &wait, nullptr);
    impl_->down.TakeIn(faults);
    impl_->up.TakeIn(faults);
  }
  return {impl_->down.counters(), impl_->up.counters()};
}

}  // namespace kawara::sim
