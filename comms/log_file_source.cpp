#include "comms/log_file_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "core/check.hpp"

namespace kawara::comms {
namespace {

constexpr std::size_t kChunkBytes = 256 << 10;  // stays in the processor's cache
constexpr std::size_t kMaxKeptBytes = 32 << 20;
// When a read fails, what is around the bad place is fetched in pieces of a disk sector.
constexpr std::size_t kSectorBytes = 4096;

}  // namespace

core::Expected<LogFileSource> LogFileSource::Open(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    const int error = errno;
    return tl::unexpected(core::ErrnoError("open log " + path.string(), error));
  }
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(fd);
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "open log " + path.string() + ": not a regular file");
  }
  (void)::posix_fadvise(fd, 0, 0, POSIX_FADV_SEQUENTIAL);
  return LogFileSource(fd, static_cast<std::uint64_t>(status.st_size));
}

LogFileSource::LogFileSource(LogFileSource&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      size_(other.size_),
      buffer_(std::move(other.buffer_)),
      capacity_(other.capacity_),
      base_(other.base_),
      filled_(other.filled_),
      unreadable_(std::move(other.unreadable_)),
      unreadable_bytes_(other.unreadable_bytes_) {}

LogFileSource::~LogFileSource() {
  if (fd_ >= 0) ::close(fd_);
}

std::span<const std::uint8_t> LogFileSource::View(std::uint64_t offset, std::size_t length,
                                                  std::uint64_t keep_from) {
  CORE_CHECK(offset <= size_ && length <= size_ - offset);
  const std::uint64_t end = offset + length;
  if (offset < base_ || end > base_ + filled_) {
    std::uint64_t begin = offset;
    if (keep_from >= base_ && keep_from < offset && offset <= base_ + filled_ &&
        end - keep_from <= kMaxKeptBytes) {
      begin = keep_from;
    }
    const std::uint64_t new_end = std::min(size_, std::max(end, offset + kChunkBytes));
    const auto needed = static_cast<std::size_t>(new_end - begin);
    const bool overlaps = begin >= base_ && begin < base_ + filled_;
    const std::size_t kept = overlaps ? static_cast<std::size_t>(base_ + filled_ - begin) : 0;
    const std::uint8_t* kept_bytes = overlaps ? buffer_.get() + (begin - base_) : nullptr;
    if (needed > capacity_) {
      const std::size_t capacity = std::max(needed, 2 * capacity_);
      auto larger = std::make_unique_for_overwrite<std::uint8_t[]>(capacity);
      if (kept > 0) std::memcpy(larger.get(), kept_bytes, kept);
      buffer_ = std::move(larger);
      capacity_ = capacity;
    } else if (kept > 0 && kept_bytes != buffer_.get()) {
      std::memmove(buffer_.get(), kept_bytes, kept);
    }
    Read(begin + kept, {buffer_.get() + kept, needed - kept});
    base_ = begin;
    filled_ = needed;
  }
  return {buffer_.get() + (offset - base_), length};
}

void LogFileSource::Peek(std::uint64_t offset, std::span<std::uint8_t> out) {
  if (offset >= base_ && offset + out.size() <= base_ + filled_) {
    std::memcpy(out.data(), buffer_.get() + (offset - base_), out.size());
  } else {
    Read(offset, out);
  }
}

std::uint64_t LogFileSource::Find(std::uint32_t big_endian_word, std::uint64_t from,
                                  std::uint64_t keep_from, std::uint64_t until) {
  std::array<std::uint8_t, 4> word{};
  for (std::size_t i = 0; i < 4; ++i)
    word[i] = static_cast<std::uint8_t>(big_endian_word >> (24 - 8 * i));
  until = std::min(until, size_);
  while (from + 4 <= until) {
    const auto length =
        static_cast<std::size_t>(std::min<std::uint64_t>(kChunkBytes, until - from));
    const auto bytes = View(from, length, keep_from);
    const void* found = ::memmem(bytes.data(), bytes.size(), word.data(), word.size());
    if (found != nullptr) {
      return from +
             static_cast<std::uint64_t>(static_cast<const std::uint8_t*>(found) - bytes.data());
    }
    from += length - 3;
  }
  return until;
}

void LogFileSource::Read(std::uint64_t offset, std::span<std::uint8_t> out) {
  while (!out.empty()) {
    const ssize_t n = ::pread(fd_, out.data(), out.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    std::size_t done = static_cast<std::size_t>(std::max<ssize_t>(n, 0));
    if (n <= 0) {
      // End of a file that was longer when opened, or a sector the disk cannot read.
      done = n == 0 ? out.size()
                    : std::min(out.size(),
                               kSectorBytes - static_cast<std::size_t>(offset % kSectorBytes));
      if (n < 0 && done < out.size()) {
        // The rest may be readable: go on a sector at a time.
        std::fill_n(out.data(), done, std::uint8_t{0});
        const ssize_t one = ::pread(fd_, out.data(), done, static_cast<off_t>(offset));
        if (one == static_cast<ssize_t>(done)) {
          out = out.subspan(done);
          offset += done;
          continue;
        }
      }
      std::fill_n(out.data(), done, std::uint8_t{0});
      MarkUnreadable(offset, offset + done);
    }
    out = out.subspan(done);
    offset += done;
  }
}

void LogFileSource::MarkUnreadable(std::uint64_t begin, std::uint64_t end) {
  if (IsUnreadable(begin, end)) return;  // read again on the way back
  unreadable_bytes_ += end - begin;
  if (!unreadable_.empty() && unreadable_.back().second == begin) {
    unreadable_.back().second = end;
  } else {
    unreadable_.emplace_back(begin, end);
  }
}

bool LogFileSource::IsUnreadable(std::uint64_t begin, std::uint64_t end) const {
  return std::ranges::any_of(
      unreadable_, [&](const auto& range) { return range.first < end && begin < range.second; });
}

}  // namespace kawara::comms
