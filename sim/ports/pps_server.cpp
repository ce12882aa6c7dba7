#include "sim/ports/pps_server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <system_error>

#include "drivers/pps_socket.hpp"
#include "sim/ports/unix_listener.hpp"

namespace kawara::sim {
namespace {

constexpr std::size_t kMostClients = 8;

}  // namespace

PpsServer::~PpsServer() {
  for (const int fd : client_fds_) close(fd);
  if (listen_fd_ < 0) return;
  close(listen_fd_);
  std::error_code ignored;
  std::filesystem::remove(socket_path_, ignored);
}

core::Expected<void> PpsServer::Listen() {
  auto fd = ListenUnix(socket_path_, "pulse");
  if (!fd) return tl::unexpected(fd.error());
  listen_fd_ = *fd;
  return {};
}

void PpsServer::Accept() {
  for (;;) {
    const int fd = accept4(listen_fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    if (client_fds_.size() < kMostClients) {
      client_fds_.push_back(fd);
    } else {
      close(fd);
    }
  }
}

void PpsServer::Send(const drivers::PpsEdge& edge) {
  Accept();
  drivers::PpsEdgeMessage message;
  message.sequence = edge.sequence;
  message.mono_ns = edge.mono.ns();
  std::erase_if(client_fds_, [&message](int fd) {
    // 16 bytes go in whole or not at all.
    if (send(fd, &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof message)
      return false;
    close(fd);
    return true;
  });
}

}  // namespace kawara::sim
