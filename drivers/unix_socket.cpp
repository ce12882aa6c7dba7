#include "drivers/unix_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace kawara::drivers {

core::Expected<int> ConnectUnix(const std::string& path, const std::string& what,
                                const std::string& who) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      what + " '" + path + "': the path must have 1 to 107 characters");
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return tl::unexpected(core::ErrnoError("open a " + what, errno));
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int reason = errno;
    close(fd);
    return core::Fail(
        core::ErrorCode::kUnavailable,
        what + " " + path + ": " + std::strerror(reason) + " (is " + who + " running?)");
  }
  return fd;
}

}  // namespace kawara::drivers
