#pragma once
#include <cstddef>
#include <cstdint>
#include <istream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::gis {

/// Bytes of a stream through a window that grows only when asked to. One thread only.
class ByteSource {
 public:
  /// Errors: kNotFound, kPermission, kIo (a folder, say).
  static core::Expected<ByteSource> Open(const std::string& path, std::size_t buffer_bytes);
  ByteSource(std::unique_ptr<std::istream> stream, std::string name, std::size_t buffer_bytes);

  /// At least `bytes` from here on, fewer only at the end of the file. Valid until the next call.
  std::span<const std::uint8_t> Peek(std::size_t bytes);
  void Take(std::size_t bytes);    ///< steps over bytes that Peek showed
  bool Skip(std::uint64_t bytes);  ///< over any bytes; false: the file ends before
  bool Seek(std::uint64_t offset);
  std::uint64_t offset() const { return offset_; }
  std::uint64_t size() const { return size_; }
  const std::string& name() const { return name_; }

  /// A line without its end ("\n", "\r\n"); false: nothing left, or longer than `most` bytes.
  bool Line(std::string_view& line, std::size_t most);

 private:
  std::unique_ptr<std::istream> stream_;
  std::string name_;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0, end_ = 0;  ///< in buffer_
  std::uint64_t offset_ = 0;         ///< in the file, of begin_
  std::uint64_t size_ = 0;
  std::size_t step_;
};

}  // namespace kawara::gis
