#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/expected.hpp"
#include "drivers/pps.hpp"

namespace kawara::sim {

/// The pulse line's end at the robot's computer as a UNIX socket (protocol:
/// drivers/pps_socket.hpp). Nothing here waits; a client that does not read is dropped. One thread.
class PpsServer {
 public:
  explicit PpsServer(std::filesystem::path socket) : socket_path_(std::move(socket)) {}
  ~PpsServer();
  PpsServer(const PpsServer&) = delete;
  PpsServer& operator=(const PpsServer&) = delete;

  core::Expected<void> Listen();
  /// To everybody who has connected by now.
  void Send(const drivers::PpsEdge& edge);

 private:
  void Accept();

  std::filesystem::path socket_path_;
  int listen_fd_ = -1;
  std::vector<int> client_fds_;
};

}  // namespace kawara::sim
