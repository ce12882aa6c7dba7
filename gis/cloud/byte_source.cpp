#include "gis/cloud/byte_source.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

namespace kawara::gis {

core::Expected<ByteSource> ByteSource::Open(const std::string& path, std::size_t buffer_bytes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return core::Fail(core::ErrorCode::kIo, path + ": is a folder, not a file");
  errno = 0;
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*file) return tl::unexpected(core::ErrnoError(path, errno == 0 ? EIO : errno));
  return ByteSource(std::move(file), path, buffer_bytes);
}

ByteSource::ByteSource(std::unique_ptr<std::istream> stream, std::string name,
                       std::size_t buffer_bytes)
    : stream_(std::move(stream)),
      name_(std::move(name)),
      step_(std::max<std::size_t>(buffer_bytes, 1)) {
  stream_->seekg(0, std::ios::end);
  const auto end = stream_->tellg();
  size_ = end > 0 ? static_cast<std::uint64_t>(end) : 0;
  Seek(0);
}

std::span<const std::uint8_t> ByteSource::Peek(std::size_t bytes) {
  while (end_ - begin_ < bytes && *stream_) {
    if (begin_ > 0) {
      std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    if (buffer_.size() < end_ + step_) buffer_.resize(end_ + step_);
    stream_->read(reinterpret_cast<char*>(buffer_.data() + end_),
                  static_cast<std::streamsize>(step_));
    end_ += static_cast<std::size_t>(stream_->gcount());
  }
  return {buffer_.data() + begin_, end_ - begin_};
}

void ByteSource::Take(std::size_t bytes) {
  const std::size_t taken = std::min(bytes, end_ - begin_);
  begin_ += taken;
  offset_ += taken;
}

bool ByteSource::Skip(std::uint64_t bytes) {
  if (bytes <= end_ - begin_) {
    Take(static_cast<std::size_t>(bytes));
    return true;
  }
  return bytes <= size_ && offset_ <= size_ - bytes && Seek(offset_ + bytes);
}

bool ByteSource::Seek(std::uint64_t offset) {
  begin_ = end_ = 0;
  if (offset > size_) return false;
  stream_->clear();
  stream_->seekg(static_cast<std::streamoff>(offset));
  offset_ = offset;
  return stream_->good();
}

bool ByteSource::Line(std::string_view& line, std::size_t most) {
  std::size_t looked = 0;
  for (std::size_t want = 256;; want *= 2) {
    const auto bytes = Peek(std::min(want, most));
    const auto seen = bytes.first(std::min(bytes.size(), most));
    const auto end = std::find(seen.begin() + static_cast<std::ptrdiff_t>(looked), seen.end(),
                               static_cast<std::uint8_t>('\n'));
    if (end == seen.end() && seen.size() == bytes.size() && bytes.size() >= want) {
      looked = seen.size();
      if (looked >= most) return false;
      continue;
    }
    if (end == seen.end() && (seen.empty() || seen.size() >= most)) return false;
    auto length = static_cast<std::size_t>(end - seen.begin());
    line = {reinterpret_cast<const char*>(seen.data()), length};
    if (line.ends_with('\r')) line.remove_suffix(1);
    Take(end == seen.end() ? length
                           : length + 1);  // what was shown stays valid until the next Peek
    return true;
  }
}

}  // namespace kawara::gis
