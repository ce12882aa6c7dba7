#include "tools/navigate/line_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <utility>

namespace kawara::navigate {
namespace {

constexpr std::size_t kBlockBytes = 262'144;
constexpr std::size_t kMaxLineBytes = 65'536;

}  // namespace

core::Expected<LineFile> LineFile::Open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return tl::unexpected(core::ErrnoError("open " + path, errno));
  struct stat info {};
  if (::fstat(fd, &info) != 0 || S_ISDIR(info.st_mode)) {
    ::close(fd);
    return core::Fail(core::ErrorCode::kInvalidArgument, path + ": is a directory, not a CSV file");
  }
  gzFile file = ::gzdopen(fd, "rb");
  if (file == nullptr) {
    ::close(fd);
    return core::Fail(core::ErrorCode::kIo, "open " + path + ": out of memory");
  }
  ::gzbuffer(file, kBlockBytes);
  return LineFile(path, file, S_ISREG(info.st_mode) ? info.st_size : 0);
}

LineFile::LineFile(LineFile&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, nullptr)),
      bytes_(other.bytes_),
      block_(std::move(other.block_)),
      begin_(other.begin_),
      line_number_(other.line_number_),
      at_end_(other.at_end_) {}

LineFile::~LineFile() {
  if (file_ != nullptr) ::gzclose(file_);
}

/// Appends a block; false at the end of the file.
core::Expected<bool> LineFile::Fill() {
  if (at_end_) return false;
  block_.erase(0, begin_);
  begin_ = 0;
  const std::size_t held = block_.size();
  block_.resize(held + kBlockBytes);
  const int got = ::gzread(file_, block_.data() + held, kBlockBytes);
  block_.resize(held + static_cast<std::size_t>(std::max(got, 0)));
  int error = Z_OK;
  const char* text = ::gzerror(file_, &error);
  // A file that was cut gives Z_BUF_ERROR behind its last good byte.
  if (got < 0 || error == Z_BUF_ERROR) {
    if (error == Z_ERRNO) return tl::unexpected(core::ErrnoError("read " + path_, errno));
    return core::Fail(
        core::ErrorCode::kFormat,
        path_ + ": damaged or cut gzip (" + (text != nullptr ? text : "") + "): copy it again");
  }
  at_end_ = got == 0;
  return got > 0;
}

core::Expected<std::optional<std::string_view>> LineFile::Next() {
  std::size_t searched = 0;
  for (;;) {
    const std::size_t newline = block_.find('\n', begin_ + searched);
    std::size_t end = newline;
    if (newline == std::string::npos) {
      searched = block_.size() - begin_;
      if (searched > kMaxLineBytes) {
        return core::Fail(core::ErrorCode::kFormat, path_ + ":" + std::to_string(line_number_ + 1) +
                                                        ": a line of more than 64 KB: no CSV file");
      }
      const auto more = Fill();
      if (!more) return tl::unexpected(more.error());
      if (*more) continue;
      if (begin_ == block_.size()) return std::optional<std::string_view>();
      end = block_.size();
    }
    std::string_view line = std::string_view(block_).substr(begin_, end - begin_);
    begin_ = newline == std::string::npos ? block_.size() : newline + 1;
    ++line_number_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line_number_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    return std::optional<std::string_view>(line);
  }
}

double LineFile::progress() const {
  if (bytes_ <= 0) return 0.0;
  return static_cast<double>(::gzoffset(file_)) / static_cast<double>(bytes_);
}

}  // namespace kawara::navigate
