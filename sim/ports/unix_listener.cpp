#include "sim/ports/unix_listener.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace kawara::sim {

core::Expected<int> ListenUnix(const std::filesystem::path& path, std::string_view what) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = std::string(what) + " socket " + path.string();
  const std::string text = path.string();
  if (text.size() >= sizeof address.sun_path) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      name + ": longer than 107 characters; choose a shorter --run-dir");
  }
  std::memcpy(address.sun_path, text.c_str(), text.size() + 1);
  std::error_code ignored;
  if (std::filesystem::is_socket(path, ignored)) std::filesystem::remove(path, ignored);
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(fd, 4) != 0) {
    const core::Error error = core::ErrnoError(name, errno);
    if (fd >= 0) close(fd);
    return tl::unexpected(error);
  }
  return fd;
}

}  // namespace kawara::sim
