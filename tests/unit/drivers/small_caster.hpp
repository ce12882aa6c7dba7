#pragma once
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace kawara::drivers::testing {

/// An NTRIP caster of one thread on a loopback port of the system's choice. For every connection it
/// reads the request up to the blank line and hands it, with the number of the connection, to
/// `answer`; it sends what comes back, keeps reading what the client uploads, and closes after
/// `hold` is over or the client is gone.
class SmallCaster {
 public:
  struct Answer {
    std::string text;
    bool close_at_once = false;
  };
  using Script = std::function<Answer(int connection, const std::string& request)>;

  explicit SmallCaster(Script answer) : answer_(std::move(answer)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::listen(listener_, 8) != 0)
      std::abort();
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Run(); });
  }
  ~SmallCaster() {
    stop_ = true;
    thread_.join();
    ::close(listener_);
  }
  std::uint16_t port() const { return port_; }
  int connections() const { return connections_; }
  /// The newest request, up to its blank line.
  std::string request() const {
    const std::lock_guard lock(mutex_);
    return request_;
  }
  std::string uploaded() const {
    const std::lock_guard lock(mutex_);
    return uploaded_;
  }

 private:
  bool WaitFor(int fd) const {
    while (!stop_) {
      pollfd entry{fd, POLLIN, 0};
      if (::poll(&entry, 1, 5) > 0) return true;
    }
    return false;
  }
  void Run() {
    while (WaitFor(listener_)) {
      const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) continue;
      Serve(client, ++connections_);
      ::close(client);
    }
  }
  void Serve(int client, int connection) {
    std::string request;
    char buffer[1024];
    while (request.find("\r\n\r\n") == std::string::npos) {
      if (!WaitFor(client)) return;
      const ssize_t n = ::recv(client, buffer, sizeof(buffer), 0);
      if (n <= 0) return;
      request.append(buffer, static_cast<std::size_t>(n));
    }
    {
      const std::lock_guard lock(mutex_);
      request_ = request;
    }
    const Answer answer = answer_(connection, request);
    (void)!::send(client, answer.text.data(), answer.text.size(), MSG_NOSIGNAL);
    while (!answer.close_at_once && WaitFor(client)) {
      const ssize_t n = ::recv(client, buffer, sizeof(buffer), 0);
      if (n <= 0) return;
      const std::lock_guard lock(mutex_);
      uploaded_.append(buffer, static_cast<std::size_t>(n));
    }
  }

  const Script answer_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> stop_{false};
  std::atomic<int> connections_{0};
  mutable std::mutex mutex_;
  std::string request_;
  std::string uploaded_;
  std::thread thread_;
};

}  // namespace kawara::drivers::testing
