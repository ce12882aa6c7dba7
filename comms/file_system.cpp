#include "comms/file_system.hpp"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace kawara::comms {
namespace {

tl::unexpected<core::Error> Errno(const std::string& what, const std::filesystem::path& path) {
  const int error = errno;
  return tl::unexpected(core::ErrnoError(what + " " + path.string(), error));
}

class PosixFile : public OutputFile {
 public:
  PosixFile(int fd, std::filesystem::path path) : fd_(fd), path_(std::move(path)) {}
  PosixFile(const PosixFile&) = delete;
  PosixFile& operator=(const PosixFile&) = delete;
  ~PosixFile() override { ::close(fd_); }

  core::Expected<std::size_t> Write(std::span<const std::uint8_t> bytes) override {
    while (true) {
      const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
      if (n >= 0) return static_cast<std::size_t>(n);
      if (errno != EINTR) return Errno("write", path_);
    }
  }
  core::Expected<void> Sync() override {
    if (::fdatasync(fd_) != 0) return Errno("fdatasync", path_);
    return {};
  }
  core::Expected<void> Allocate(std::uint64_t bytes) override {
    const int error = ::posix_fallocate(fd_, 0, static_cast<off_t>(bytes));
    if (error != 0) {
      return tl::unexpected(core::ErrnoError(
          "reserve " + std::to_string(bytes >> 20) + " MiB in " + path_.string(), error));
    }
    return {};
  }

 private:
  int fd_;
  std::filesystem::path path_;
};

// Without this a power cut can take the file itself although its data were synced.
core::Expected<void> SyncFolder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return Errno("open folder", folder);
  const int result = ::fsync(fd);
  const int error = errno;
  ::close(fd);
  // Some network and FUSE file systems cannot sync a folder: nothing more can be done there.
  if (result != 0 && error != EINVAL && error != ENOTSUP) {
    return tl::unexpected(core::ErrnoError("fsync folder " + folder.string(), error));
  }
  return {};
}

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  const std::filesystem::path parent = path.parent_path();
  return parent.empty() ? std::filesystem::path(".") : parent;
}

class Posix : public FileSystem {
 public:
  core::Expected<std::unique_ptr<OutputFile>> Create(const std::filesystem::path& path) override {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
    if (fd < 0 && errno == EEXIST) {
      return core::Fail(
          core::ErrorCode::kInvalidArgument,
          "create " + path.string() + ": exists already (a log is never overwritten)");
    }
    if (fd < 0) return Errno("create", path);
    auto file = std::make_unique<PosixFile>(fd, path);
    if (auto ok = SyncFolder(FolderOf(path)); !ok) return tl::unexpected(std::move(ok.error()));
    return file;
  }
  core::Expected<void> CreateFolder(const std::filesystem::path& path) override {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error)
      return tl::unexpected(core::ErrnoError("create folder " + path.string(), error.value()));
    return SyncFolder(FolderOf(path));
  }
  core::Expected<void> Remove(const std::filesystem::path& path) override {
    if (::unlink(path.c_str()) != 0) return Errno("delete", path);
    return {};
  }
  core::Expected<std::uint64_t> FreeBytes(const std::filesystem::path& path) override {
    struct statvfs disk {};
    if (::statvfs(path.c_str(), &disk) != 0) return Errno("free space of", path);
    return std::uint64_t{disk.f_bavail} * disk.f_frsize;
  }
  std::vector<std::filesystem::path> List(const std::filesystem::path& folder) override {
    std::vector<std::filesystem::path> found;
    std::error_code error;
    std::filesystem::directory_iterator entry(folder, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
      std::error_code ignored;
      const auto status = entry->symlink_status(ignored);
      if (std::filesystem::is_regular_file(status) || std::filesystem::is_directory(status)) {
        found.push_back(entry->path());
      }
    }
    std::ranges::sort(found);
    return found;
  }
};

}  // namespace

FileSystem& PosixFileSystem() {
  static Posix posix;
  return posix;
}

}  // namespace kawara::comms
