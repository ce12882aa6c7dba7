#pragma once
#include <atomic>
#include <cerrno>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "comms/file_system.hpp"

namespace kawara::comms {

/// The real disk with a size of its own and faults at will. Any thread.
class FaultyFileSystem : public FileSystem {
 public:
  std::uint64_t capacity_bytes = UINT64_MAX;
  int failing_writes = 0;  ///< so many next writes end in EIO
  int failing_syncs =
      0;  ///< so many next syncs end in EIO, and the kernel forgets what was not synced
  int failing_creates = 0;
  std::atomic<bool> hold_writes{false};  ///< a write stays in the disk until this is false again
  std::atomic<int> held{0};              ///< so many are in there
  std::recursive_mutex mutex;

  core::Expected<std::unique_ptr<OutputFile>> Create(const std::filesystem::path& path) override {
    const std::lock_guard lock(mutex);
    if (failing_creates > 0 && failing_creates-- > 0)
      return tl::unexpected(core::ErrnoError("create " + path.string(), EIO));
    auto file = PosixFileSystem().Create(path);
    if (!file) return tl::unexpected(file.error());
    sizes_[path] = 0;
    return std::make_unique<File>(*this, path, std::move(*file));
  }
  core::Expected<void> CreateFolder(const std::filesystem::path& path) override {
    return PosixFileSystem().CreateFolder(path);
  }
  core::Expected<void> Remove(const std::filesystem::path& path) override {
    const std::lock_guard lock(mutex);
    sizes_.erase(path);
    return PosixFileSystem().Remove(path);
  }
  core::Expected<std::uint64_t> FreeBytes(const std::filesystem::path&) override { return Free(); }
  std::vector<std::filesystem::path> List(const std::filesystem::path& folder) override {
    return PosixFileSystem().List(folder);
  }

 private:
  class File : public OutputFile {
   public:
    File(FaultyFileSystem& disk, std::filesystem::path path, std::unique_ptr<OutputFile> file)
        : disk_(&disk), path_(std::move(path)), file_(std::move(file)) {}
    core::Expected<std::size_t> Write(std::span<const std::uint8_t> bytes) override {
      ++disk_->held;
      while (disk_->hold_writes) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      --disk_->held;
      const std::lock_guard lock(disk_->mutex);
      if (disk_->failing_writes > 0 && disk_->failing_writes-- > 0) return Fail("write", EIO);
      const std::uint64_t room = disk_->Free();
      if (room == 0) return Fail("write", ENOSPC);
      const auto n = file_->Write(bytes.first(std::min<std::size_t>(bytes.size(), room)));
      if (n) disk_->sizes_[path_] += *n;
      if (n) written_ += *n;
      return n;
    }
    core::Expected<void> Sync() override {
      const std::lock_guard lock(disk_->mutex);
      if (disk_->failing_syncs > 0 && disk_->failing_syncs-- > 0) {
        std::filesystem::resize_file(path_, synced_);
        return Fail("fdatasync", EIO);
      }
      synced_ = std::filesystem::file_size(path_);
      return {};
    }
    core::Expected<void> Allocate(std::uint64_t bytes) override {
      const std::lock_guard lock(disk_->mutex);
      if (disk_->Free() < bytes) return Fail("reserve", ENOSPC);
      disk_->sizes_[path_] = bytes;
      return {};
    }

   private:
    tl::unexpected<core::Error> Fail(const char* what, int error) {
      return tl::unexpected(core::ErrnoError(std::string(what) + " " + path_.string(), error));
    }
    FaultyFileSystem* disk_;
    std::filesystem::path path_;
    std::unique_ptr<OutputFile> file_;
    std::uint64_t written_ = 0;
    std::uint64_t synced_ = 0;
  };

  std::uint64_t Free() {
    const std::lock_guard lock(mutex);
    std::uint64_t used = 0;
    for (const auto& [path, size] : sizes_) used += size;
    return capacity_bytes > used ? capacity_bytes - used : 0;
  }
  std::map<std::filesystem::path, std::uint64_t> sizes_;
};

}  // namespace kawara::comms
