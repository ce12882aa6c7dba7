#pragma once
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "core/expected.hpp"

namespace kawara::navigate {

/// A file that is there whole or not at all: written beside its place as "NAME.part", renamed by
/// Commit(). What is not committed is removed, also when a signal ends the program (SIGKILL leaves
/// the .part, which the next run writes over). What is no regular file (/dev/stdout, a pipe) is
/// written directly. One thread.
class SafeFile {
 public:
  /// Errors: kNotFound, kPermission, kIo, kInvalidArgument (a directory).
  static core::Expected<SafeFile> Create(const std::string& path);
  SafeFile(SafeFile&&) noexcept;
  SafeFile& operator=(SafeFile&&) = delete;
  SafeFile(const SafeFile&) = delete;
  SafeFile& operator=(const SafeFile&) = delete;
  ~SafeFile();

  /// Errors: kFull, kIo.
  core::Expected<void> Write(std::string_view text);
  /// Everything is on the disk and has its name. Errors: kFull, kIo, kPermission.
  core::Expected<void> Commit();
  const std::string& path() const { return path_; }

 private:
  SafeFile(std::string path, std::string part, std::FILE* file)
      : path_(std::move(path)), part_(std::move(part)), file_(file) {}

  std::string path_;
  std::string part_;  ///< empty: written directly
  std::FILE* file_;
};

}  // namespace kawara::navigate
