#include "gis/picture_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace kawara::gis {
namespace {

tl::unexpected<core::Error> Errno(const std::string& doing, const std::filesystem::path& path) {
  const int number = errno;
  core::Error error = core::ErrnoError(doing + " " + path.string(), number);
  if (number == EFBIG) error.code = core::ErrorCode::kFull;  // a file size limit is a full disk
  if (error.code == core::ErrorCode::kFull) error.message += " (free some space)";
  if (error.code == core::ErrorCode::kPermission) error.message += " (the folder must be writable)";
  return tl::unexpected(std::move(error));
}

core::Expected<void> WriteAll(int fd, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return core::Fail(core::ErrorCode::kIo, "");
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

bool IsTemporary(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') && name.ends_with(".jpg.tmp");
}

}  // namespace

core::Expected<void> SyncFolder(const std::filesystem::path& folder) {
  const std::filesystem::path name = folder.empty() ? std::filesystem::path(".") : folder;
  const int fd = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return Errno("open", name);
  const int result = ::fsync(fd);
  const int number = errno;
  ::close(fd);
  errno = number;
  if (result != 0) return Errno("fsync", name);
  return {};
}

core::Expected<void> MakeFolders(const std::filesystem::path& folder) {
  if (folder.empty()) return {};
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored)) {
    // A killed predecessor may have made it without coming to the fsync.
    return folder.has_relative_path() ? SyncFolder(folder.parent_path()) : core::Expected<void>();
  }
  if (auto parent = MakeFolders(folder.parent_path()); !parent) return parent;
  if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) return Errno("mkdir", folder);
  return SyncFolder(folder.parent_path());
}

core::Expected<PictureFolder> PictureFolder::Open(const std::filesystem::path& folder) {
  if (auto made = MakeFolders(folder); !made) return tl::unexpected(made.error());
  if (::access(folder.c_str(), W_OK | X_OK) != 0) return Errno("write to", folder);
  std::error_code ignored;
  using Walk = std::filesystem::recursive_directory_iterator;
  std::vector<std::filesystem::path> stale;
  for (Walk it(folder, std::filesystem::directory_options::skip_permission_denied, ignored), end;
       !ignored && it != end; it.increment(ignored)) {
    if (IsTemporary(it->path())) stale.push_back(it->path());
  }
  for (const auto& path : stale) std::filesystem::remove(path, ignored);
  return PictureFolder(folder);
}

PictureFolder::PictureFolder(PictureFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      staged_(std::exchange(other.staged_, {})),
      durable_(std::move(other.durable_)) {}

PictureFolder& PictureFolder::operator=(PictureFolder&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(staged_, other.staged_);
  std::swap(durable_, other.durable_);
  return *this;
}

PictureFolder::~PictureFolder() { Abort(); }

core::Expected<void> PictureFolder::Prepare(const std::filesystem::path& parent) {
  if (durable_.contains(parent)) return {};
  for (auto folder = parent; folder != folder_ && folder.has_relative_path();
       folder = folder.parent_path())
    if (auto made = MakeFolders(folder); !made) return made;
  constexpr std::size_t kMostRemembered = 1000;  // names come from packets
  if (durable_.size() >= kMostRemembered) durable_.clear();
  durable_.insert(parent);
  return {};
}

core::Expected<void> PictureFolder::Stage(const std::string& relative,
                                          std::span<const std::uint8_t> bytes) {
  Staged staged;
  staged.final = folder_ / relative;
  const std::filesystem::path parent = staged.final.parent_path();
  if (auto made = Prepare(parent); !made) return made;
  staged.temporary = parent / ("." + staged.final.filename().string() + ".tmp");
  staged.fd =
      ::open(staged.temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (staged.fd < 0) return Errno("create", staged.temporary);
  staged_.push_back(staged);
  if (!WriteAll(staged.fd, bytes)) return Errno("write", staged.temporary);
  return {};
}

core::Expected<void> PictureFolder::Commit() {
  for (Staged& s : staged_) {
    const int result = ::fsync(s.fd);
    const int number = errno;
    ::close(s.fd);
    s.fd = -1;
    errno = number;
    if (result != 0) return Errno("fsync", s.temporary);
  }
  std::set<std::filesystem::path> folders;
  for (const Staged& s : staged_) {
    if (::rename(s.temporary.c_str(), s.final.c_str()) != 0) return Errno("rename to", s.final);
    folders.insert(s.final.parent_path());
  }
  staged_.clear();
  for (const auto& folder : folders)
    if (auto synced = SyncFolder(folder); !synced) return synced;
  return {};
}

void PictureFolder::Abort() {
  for (const Staged& s : staged_) {
    if (s.fd >= 0) ::close(s.fd);
    ::unlink(s.temporary.c_str());
  }
  staged_.clear();
}

}  // namespace kawara::gis
