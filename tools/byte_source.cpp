#include "tools/byte_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace kawara::tools {
namespace {

constexpr std::size_t kBlockBytes = 262'144;

/// A line of a remark holds text: no control characters but tab and the carriage return at its end.
bool IsText(std::span<const std::uint8_t> line) {
  for (const std::uint8_t b : line) {
    if ((b < 0x20 && b != '\t' && b != '\r') || b == 0x7f) return false;
  }
  return true;
}

}  // namespace

core::Expected<ByteSource> ByteSource::Open(const std::string& path) {
  if (path == "-") return ByteSource("standard input", ::dup(STDIN_FILENO));
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return tl::unexpected(core::ErrnoError("open " + path, errno));
  struct stat info {};
  if (::fstat(fd, &info) == 0 && S_ISDIR(info.st_mode)) {
    ::close(fd);
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path + " is a directory: name a file, or - for standard input");
  }
  return ByteSource(path, fd);
}

ByteSource::ByteSource(ByteSource&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      block_(std::move(other.block_)),
      begin_(other.begin_),
      end_(other.end_),
      started_(other.started_),
      at_end_(other.at_end_),
      comment_bytes_(other.comment_bytes_),
      error_(std::move(other.error_)) {}

ByteSource::~ByteSource() {
  if (fd_ >= 0) ::close(fd_);
}

/// Moves what is left to the front and appends what one read() gives. False at the end or on an
/// error.
bool ByteSource::Fill() {
  block_.resize(kBlockBytes);
  if (begin_ > 0) {
    std::memmove(block_.data(), block_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (at_end_ || end_ == block_.size()) return false;
  for (;;) {
    const ssize_t n = ::read(fd_, block_.data() + end_, block_.size() - end_);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      if (n < 0) error_ = core::ErrnoError("read " + path_, errno);
      at_end_ = true;
      return false;
    }
    end_ += static_cast<std::size_t>(n);
    return true;
  }
}

void ByteSource::SkipComments() {
  for (;;) {
    const void* newline = nullptr;
    for (;;) {
      if (begin_ < end_ && block_[begin_] != '#') return;
      if (begin_ < end_) {
        newline = std::memchr(block_.data() + begin_, '\n', end_ - begin_);
        if (newline != nullptr) break;
      }
      if (!Fill()) break;
    }
    const std::size_t line_end =
        newline == nullptr
            ? end_
            : static_cast<std::size_t>(static_cast<const std::uint8_t*>(newline) - block_.data());
    if (begin_ == end_ || !IsText({block_.data() + begin_, line_end - begin_})) return;
    const std::size_t next = newline == nullptr ? end_ : line_end + 1;
    comment_bytes_ += next - begin_;
    begin_ = next;
  }
}

std::span<const std::uint8_t> ByteSource::Read() {
  if (!started_) {
    started_ = true;
    SkipComments();
  }
  if (begin_ == end_) Fill();
  const std::span<const std::uint8_t> bytes(block_.data() + begin_, end_ - begin_);
  begin_ = end_;
  return bytes;
}

}  // namespace kawara::tools
