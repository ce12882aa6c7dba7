#include "core/config/config.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace kawara::core::config {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{2} << 20;  // the parser refuses above 1 MiB

tl::unexpected<Error> Unreadable(const std::string& path, int errno_value) {
  Error error = ErrnoError(path, errno_value);
  switch (error.code) {
    case ErrorCode::kNotFound:
      error.message += " (check the path of the configuration file)";
      break;
    case ErrorCode::kPermission:
      error.message += " (make it readable for this user: chmod u+r, or chown)";
      break;
    default:
      error.message += " (expected a readable YAML file)";
      break;
  }
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

Expected<std::string> ReadFile(const std::string& path) {
  // O_NONBLOCK: a FIFO given by mistake must not hang the start.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return Unreadable(path, errno);
  struct stat status {};
  int failure = ::fstat(fd, &status) != 0 ? errno : 0;
  if (failure == 0 && S_ISDIR(status.st_mode)) failure = EISDIR;
  std::string text;
  while (failure == 0 && text.size() <= kMaxFileBytes) {
    std::array<char, 4096> chunk;
    const ssize_t n = ::read(fd, chunk.data(), chunk.size());
    if (n < 0 && errno != EINTR) failure = errno;
    if (n == 0) break;
    if (n > 0) text.append(chunk.data(), static_cast<std::size_t>(n));
  }
  ::close(fd);
  if (failure != 0) return Unreadable(path, failure);
  return text;
}

Node MakeTree(std::string_view yaml, const std::string& source,
              std::span<const std::string> overrides, const std::string& expected_keys,
              Problems& problems) {
  Node root = ParseYaml(yaml, source, problems);
  if (root.kind == Node::Kind::kNull && problems.empty()) {
    problems.Add(root.place, "empty file: expected " + expected_keys);
  } else if (root.kind != Node::Kind::kMap && problems.empty()) {
    problems.Add(root.place, root.Shown() + ": expected " + expected_keys);
  }
  if (root.kind == Node::Kind::kMap) {
    for (const std::string& assignment : overrides) ApplyOverride(root, assignment, problems);
  }
  return root;
}

}  // namespace kawara::core::config
