#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "core/expected.hpp"

namespace kawara::comms {

/// A file being written, closed on destruction.
class OutputFile {
 public:
  virtual ~OutputFile() = default;
  /// Writes at the end. Returns how many bytes went in, which may be fewer; errors: kFull, kIo, ...
  [[nodiscard]] virtual core::Expected<std::size_t> Write(std::span<const std::uint8_t> bytes) = 0;
  /// On the medium when it returns (fdatasync).
  [[nodiscard]] virtual core::Expected<void> Sync() = 0;
  /// Blocks for `bytes` from the start are set aside now (posix_fallocate).
  [[nodiscard]] virtual core::Expected<void> Allocate(std::uint64_t bytes) = 0;
};

/// What the log writer and the recorder need of a disk; tests put a failing one in its place.
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  /// Creates a new file and makes its name durable (fsync of the folder). Errors: kInvalidArgument
  /// if it exists.
  [[nodiscard]] virtual core::Expected<std::unique_ptr<OutputFile>> Create(
      const std::filesystem::path& path) = 0;
  [[nodiscard]] virtual core::Expected<void> CreateFolder(const std::filesystem::path& path) = 0;
  [[nodiscard]] virtual core::Expected<void> Remove(const std::filesystem::path& path) = 0;
  /// Bytes a normal user may still write on the disk that holds `path`.
  [[nodiscard]] virtual core::Expected<std::uint64_t> FreeBytes(
      const std::filesystem::path& path) = 0;
  /// Regular files and folders (no links) directly in `folder`, sorted by name; empty if it cannot
  /// be read.
  virtual std::vector<std::filesystem::path> List(const std::filesystem::path& folder) = 0;
};

/// The real one.
FileSystem& PosixFileSystem();

}  // namespace kawara::comms
