#include "gis/model/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace kawara::gis {
namespace {

tl::unexpected<core::Error> Errno(const char* doing, const std::filesystem::path& path) {
  const int number = errno;
  return tl::unexpected(core::ErrnoError(std::string(doing) + " " + path.string(), number));
}

core::Expected<void> WriteAndSync(int fd, std::string_view bytes,
                                  const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Errno("write", path);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  if (::fsync(fd) != 0) return Errno("fsync", path);
  return {};
}

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  return path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
}

std::filesystem::path FreshNameOf(const std::filesystem::path& path) {
  return FolderOf(path) / ("." + path.filename().string() + ".tmp");
}

}  // namespace

core::Expected<void> WriteWholeFile(const std::filesystem::path& path, std::string_view bytes) {
  const std::filesystem::path folder = FolderOf(path);
  const std::filesystem::path fresh = FreshNameOf(path);
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return Errno("create", fresh);
  auto written = WriteAndSync(fd, bytes, fresh);
  ::close(fd);
  if (written && ::rename(fresh.c_str(), path.c_str()) != 0) written = Errno("rename to", path);
  if (!written) {
    ::unlink(fresh.c_str());
    return written;
  }
  const int folder_fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_fd >= 0) {
    (void)::fsync(folder_fd);  // not every file system can; the file itself is on the disk
    ::close(folder_fd);
  }
  return {};
}

core::Expected<void> CheckWritable(const std::filesystem::path& path) {
  std::error_code error;
  if (!path.has_filename() || std::filesystem::is_directory(path, error)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "write " + path.string() + ": that is a folder, expected a file's name");
  }
  std::filesystem::create_directories(FolderOf(path), error);
  if (error) {
    return tl::unexpected(
        core::ErrnoError("make folder " + FolderOf(path).string(), error.value()));
  }
  const std::filesystem::path fresh = FreshNameOf(path);
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) return Errno("write", path);
  ::close(fd);
  ::unlink(fresh.c_str());
  return {};
}

}  // namespace kawara::gis
