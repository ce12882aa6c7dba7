#include "comms/multicast.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <utility>

namespace kawara::comms {
namespace {

class Socket {
 public:
  Socket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

// The sockets API takes every address as sockaddr*.
sockaddr* Generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

tl::unexpected<core::Error> NoMulticast(const std::string& what) {
  return core::Fail(
      core::ErrorCode::kUnavailable,
      what +
          "; for messages inside this machine, as root: ip link set lo up multicast on && "
          "ip route replace 224.0.0.0/4 dev lo");
}

std::string InterfaceFlagsProblem(in_addr source) {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  std::string problem;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    const auto* address = reinterpret_cast<const sockaddr_in*>(i->ifa_addr);
    if (address->sin_addr.s_addr != source.s_addr) continue;
    if ((i->ifa_flags & IFF_UP) == 0)
      problem = std::string("interface ") + i->ifa_name + " is down";
  }
  ::freeifaddrs(list);
  return problem;
}

// A datagram to the group from the interface the route gave, back to ourselves.
core::Expected<void> SendToSelf(sockaddr_in group, in_addr source) {
  const Socket receiver;
  const Socket sender;
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_addr = group.sin_addr;  // hears this group only
  ip_mreq membership{};
  membership.imr_multiaddr = group.sin_addr;
  membership.imr_interface.s_addr = htonl(INADDR_ANY);  // as LCM does
  if (::bind(receiver.fd(), Generic(local), sizeof local) != 0 ||
      ::setsockopt(receiver.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) !=
          0) {
    return NoMulticast(core::ErrnoError("cannot join the LCM multicast group", errno).message);
  }
  socklen_t length = sizeof local;
  if (::getsockname(receiver.fd(), Generic(local), &length) != 0) {
    return tl::unexpected(core::ErrnoError("getsockname", errno));
  }
  sockaddr_in to = group;
  to.sin_port = local.sin_port;
  const unsigned char ttl = 0;
  const std::array<char, 8> probe{'k', 'a', 'w', 'a', 'r', 'a', '?', '\n'};
  if (::setsockopt(sender.fd(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0 ||
      ::sendto(sender.fd(), probe.data(), probe.size(), 0, Generic(to), sizeof to) < 0) {
    return NoMulticast(core::ErrnoError("cannot send to the LCM multicast group", errno).message);
  }
  pollfd waiting{receiver.fd(), POLLIN, 0};
  if (::poll(&waiting, 1, 500) <= 0) {
    std::array<char, INET_ADDRSTRLEN> name{};
    ::inet_ntop(AF_INET, &source, name.data(), name.size());
    return NoMulticast(std::string("multicast sent by the interface of ") + name.data() +
                       " does not come back (firewall, or an interface without multicast)");
  }
  return {};
}

}  // namespace

core::Expected<void> CheckMulticast(const std::string& group_address) {
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(7667);
  if (::inet_pton(AF_INET, group_address.c_str(), &group.sin_addr) != 1 ||
      !IN_MULTICAST(ntohl(group.sin_addr.s_addr))) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "LCM URL: '" + group_address +
                          "' is not a multicast address (224.0.0.0 to 239.255.255.255)");
  }
  const Socket probe;
  if (probe.fd() < 0) return tl::unexpected(core::ErrnoError("LCM: socket", errno));
  if (::connect(probe.fd(), Generic(group), sizeof group) != 0) {
    return NoMulticast(
        core::ErrnoError("no route for multicast to " + group_address, errno).message);
  }
  sockaddr_in source{};
  socklen_t length = sizeof source;
  if (::getsockname(probe.fd(), Generic(source), &length) != 0) {
    return tl::unexpected(core::ErrnoError("LCM: getsockname", errno));
  }
  if (const std::string problem = InterfaceFlagsProblem(source.sin_addr); !problem.empty()) {
    return NoMulticast(problem);
  }
  return SendToSelf(group, source.sin_addr);
}

long ReceiveBufferLimitBytes() {
  long limit = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> limit;
  return limit;
}

}  // namespace kawara::comms
