#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/expected.hpp"

struct gzFile_s;

namespace kawara::navigate {

/// A text file read line by line, plain or gzip (told apart by content, whatever the name says).
/// Line ends of Unix and Windows, a byte order mark at the start, a last line without end: all
/// fine. One thread.
class LineFile {
 public:
  /// Errors: kNotFound, kPermission, kIo, kInvalidArgument (a directory).
  static core::Expected<LineFile> Open(const std::string& path);
  LineFile(LineFile&& other) noexcept;
  LineFile& operator=(LineFile&&) = delete;
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;
  ~LineFile();

  /// The next line without its end, valid until the next call. Nothing at the end of the file.
  /// Errors: kIo; kFormat for damaged or cut gzip and for a line longer than 64 KB (no text file).
  core::Expected<std::optional<std::string_view>> Next();

  const std::string& path() const { return path_; }
  std::int64_t line_number() const { return line_number_; }  ///< of the last Next(), from 1
  /// How far the reading is, 0..1 of the bytes on the disk; 0 if the size is unknown (a pipe).
  double progress() const;

 private:
  LineFile(std::string path, gzFile_s* file, std::int64_t bytes)
      : path_(std::move(path)), file_(file), bytes_(bytes) {}
  core::Expected<bool> Fill();

  std::string path_;
  gzFile_s* file_;
  std::int64_t bytes_;
  std::string block_;
  std::size_t begin_ = 0;
  std::int64_t line_number_ = 0;
  bool at_end_ = false;
};

}  // namespace kawara::navigate
