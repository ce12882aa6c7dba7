#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::tools {

/// Bytes of a file, or of standard input ("-"), in blocks: a recording of any size takes the same
/// memory. Lines of text that begin with '#' at the very start of the file are somebody's remarks
/// about the recording (gpsd's regression logs have them), not bytes of the instrument: they are
/// left out and counted. One thread.
class ByteSource {
 public:
  /// Errors: kNotFound, kPermission, kInvalidArgument (a directory), kIo.
  static core::Expected<ByteSource> Open(const std::string& path);
  ByteSource(ByteSource&& other) noexcept;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  ByteSource& operator=(ByteSource&&) = delete;
  ~ByteSource();

  /// The next bytes, valid until the next call. Empty: end of file, or error() says why not.
  std::span<const std::uint8_t> Read();
  const std::optional<core::Error>& error() const { return error_; }

  /// How many bytes of remarks were left out at the start: the offset in the file of the first byte
  /// of Read().
  std::uint64_t comment_bytes() const { return comment_bytes_; }

 private:
  ByteSource(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  bool Fill();
  void SkipComments();

  std::string path_;
  int fd_;
  std::vector<std::uint8_t> block_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool started_ = false;
  bool at_end_ = false;
  std::uint64_t comment_bytes_ = 0;
  std::optional<core::Error> error_;
};

}  // namespace kawara::tools
