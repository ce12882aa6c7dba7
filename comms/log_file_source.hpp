#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/expected.hpp"

namespace kawara::comms {

/// Bytes of one file anywhere in it, through a buffer that follows the reader. Reading rather than
/// mapping: a sector that cannot be read, or a file cut while it is read, is then a counted hole
/// and not a SIGBUS. What cannot be read comes as zeros and IsUnreadable() says so. One thread
/// only.
class LogFileSource {
 public:
  [[nodiscard]] static core::Expected<LogFileSource> Open(const std::filesystem::path& path);
  LogFileSource(LogFileSource&& other) noexcept;
  LogFileSource& operator=(LogFileSource&&) = delete;
  ~LogFileSource();

  /// At the time it was opened.
  std::uint64_t size() const { return size_; }
  /// [offset, offset + length), which must lie in the file; valid until the next call. Bytes from
  /// `keep_from` on stay in the buffer if they are there and it is not too much: the caller will be
  /// back for them.
  std::span<const std::uint8_t> View(std::uint64_t offset, std::size_t length,
                                     std::uint64_t keep_from);
  /// Copies a few bytes from anywhere without moving the buffer.
  void Peek(std::uint64_t offset, std::span<std::uint8_t> out);
  /// First place in [from, until) where these four bytes stand; the smaller of until and size() if
  /// nowhere.
  std::uint64_t Find(std::uint32_t big_endian_word, std::uint64_t from, std::uint64_t keep_from,
                     std::uint64_t until = UINT64_MAX);

  bool IsUnreadable(std::uint64_t begin, std::uint64_t end) const;
  std::uint64_t unreadable_bytes() const { return unreadable_bytes_; }

 private:
  LogFileSource(int fd, std::uint64_t size) : fd_(fd), size_(size) {}
  void Read(std::uint64_t offset, std::span<std::uint8_t> out);
  void MarkUnreadable(std::uint64_t begin, std::uint64_t end);

  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::unique_ptr<std::uint8_t[]> buffer_;
  std::size_t capacity_ = 0;
  std::uint64_t base_ = 0;  ///< file offset of buffer_[0]
  std::size_t filled_ = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> unreadable_;
  std::uint64_t unreadable_bytes_ = 0;
};

}  // namespace kawara::comms
