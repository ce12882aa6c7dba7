#include "tools/navigate/safe_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

namespace kawara::navigate {
namespace {

// What a signal handler has to remove: fixed memory, because it may not allocate nor lock.
constexpr std::size_t kMost = 4;
constexpr std::size_t kLongestPath = 4096;
struct Unfinished {
  std::atomic<bool> used = false;
  std::array<char, kLongestPath> path{};
};
std::array<Unfinished, kMost> g_unfinished;

extern "C" void RemoveUnfinished(int signal_number) {
  for (Unfinished& file : g_unfinished) {
    if (file.used.load(std::memory_order_acquire)) ::unlink(file.path.data());
  }
  // The handler was installed for one shot: now the signal does what it does.
  ::raise(signal_number);
}

void InstallHandlers() {
  static const bool installed = [] {
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGXFSZ}) {
      struct sigaction action {};
      if (::sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
      action = {};
      action.sa_handler = RemoveUnfinished;
      action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
      ::sigaction(number, &action, nullptr);
    }
    return true;
  }();
  (void)installed;
}

void Remember(const std::string& part) {
  if (part.size() >= kLongestPath) return;
  for (Unfinished& file : g_unfinished) {
    if (file.used.load(std::memory_order_relaxed)) continue;
    std::memcpy(file.path.data(), part.c_str(), part.size() + 1);
    file.used.store(true, std::memory_order_release);
    return;
  }
}

void Forget(const std::string& part) {
  for (Unfinished& file : g_unfinished) {
    if (file.used.load(std::memory_order_relaxed) && part == file.path.data()) {
      file.used.store(false, std::memory_order_release);
    }
  }
}

}  // namespace

core::Expected<SafeFile> SafeFile::Create(const std::string& path) {
  struct stat info {};
  const bool exists = ::stat(path.c_str(), &info) == 0;
  if (exists && S_ISDIR(info.st_mode)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "write " + path + ": is a directory: name a file in it");
  }
  const bool direct = exists && !S_ISREG(info.st_mode);
  const std::string part = direct ? std::string() : path + ".part";
  const std::string& opened = direct ? path : part;
  std::FILE* file = std::fopen(opened.c_str(), "we");
  if (file == nullptr) return tl::unexpected(core::ErrnoError("write " + path, errno));
  if (!direct) {
    InstallHandlers();
    Remember(part);
  }
  return SafeFile(path, part, file);
}

SafeFile::SafeFile(SafeFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_(std::exchange(other.part_, {})),
      file_(std::exchange(other.file_, nullptr)) {}

SafeFile::~SafeFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (part_.empty()) return;
  ::unlink(part_.c_str());
  Forget(part_);
}

core::Expected<void> SafeFile::Write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) {
    return tl::unexpected(core::ErrnoError("write " + path_, errno));
  }
  return {};
}

core::Expected<void> SafeFile::Commit() {
  // A pipe or a terminal cannot be synced, and need not.
  const bool flushed = std::fflush(file_) == 0 && (part_.empty() || ::fsync(::fileno(file_)) == 0);
  const int flush_error = errno;
  const bool closed = std::fclose(std::exchange(file_, nullptr)) == 0;
  if (!flushed || !closed) {
    return tl::unexpected(core::ErrnoError("write " + path_, flushed ? errno : flush_error));
  }
  if (part_.empty()) return {};
  if (std::rename(part_.c_str(), path_.c_str()) != 0) {
    return tl::unexpected(core::ErrnoError("rename " + part_ + " to " + path_, errno));
  }
  Forget(part_);
  part_.clear();
  return {};
}

}  // namespace kawara::navigate
