#include "vision/voxel/spill_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>

#include "vision/voxel/spill_record.hpp"

namespace kawara::vision {
namespace {

template <class T>
std::span<const std::uint8_t> BytesOf(const T& value) {
  return {reinterpret_cast<const std::uint8_t*>(&value), sizeof(T)};
}

void SyncFolderOf(const std::string& path) {
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  (void)::fsync(fd);  // not every file system can; the file's own fsync has been checked
  ::close(fd);
}

}  // namespace

tl::unexpected<core::Error> SpillFile::Errno(const char* doing) const {
  const int number = errno;
  return tl::unexpected(core::ErrnoError(std::string(doing) + " " + path_, number));
}

core::Expected<SpillFile> SpillFile::Open(const std::string& path, double voxel_m) {
  SpillFile file;
  file.path_ = path;
  file.contents_.voxel_m = voxel_m;
  file.fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file.fd_ < 0) return file.Errno("open");
  struct stat status {};
  if (::fstat(file.fd_, &status) != 0) return file.Errno("stat");
  if (!S_ISREG(status.st_mode))
    return core::Fail(core::ErrorCode::kInvalidArgument, path + ": not a regular file");
  file.end_ = static_cast<std::uint64_t>(status.st_size);
  if (file.end_ < sizeof(SpillFileHeader)) {
    // New, or its maker was killed within the first 24 bytes; nothing can have been committed.
    if (::ftruncate(file.fd_, 0) != 0) return file.Errno("truncate");
    file.end_ = 0;
    if (auto written = file.WriteHeader(); !written) return tl::unexpected(written.error());
    SyncFolderOf(path);
    return file;
  }
  if (auto loaded = file.Load(); !loaded) return tl::unexpected(loaded.error());
  if (file.contents_.voxel_m != voxel_m) {
    char text[160];
    std::snprintf(text, sizeof(text), ": voxels of %.9g m, not of %.9g m (remove it to begin anew)",
                  file.contents_.voxel_m, voxel_m);
    return core::Fail(core::ErrorCode::kFormat, path + text);
  }
  return file;
}

core::Expected<void> SpillFile::Load() {
  void* const mapped = ::mmap(nullptr, end_, PROT_READ, MAP_PRIVATE, fd_, 0);
  if (mapped == MAP_FAILED) return Errno("map");
  auto contents = ScanSpill({static_cast<const std::uint8_t*>(mapped), end_});
  ::munmap(mapped, end_);
  if (!contents)
    return core::Fail(contents.error().code,
                      path_ + ": " + contents.error().message + " (remove it to begin anew)");
  contents_ = std::move(*contents);
  // What came after the commit does not count and would lie in the way of new records.
  if (contents_.committed_bytes < end_) {
    if (::ftruncate(fd_, static_cast<off_t>(contents_.committed_bytes)) != 0)
      return Errno("truncate");
    end_ = contents_.committed_bytes;
  }
  return {};
}

SpillFile::SpillFile(SpillFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      end_(other.end_),
      contents_(std::move(other.contents_)) {}

SpillFile& SpillFile::operator=(SpillFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  std::swap(end_, other.end_);
  std::swap(contents_, other.contents_);
  return *this;
}

SpillFile::~SpillFile() {
  if (fd_ >= 0) ::close(fd_);
}

core::Expected<void> SpillFile::WriteAll(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(end_));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Errno("write");
    end_ += static_cast<std::uint64_t>(n);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

core::Expected<void> SpillFile::WriteHeader() {
  SpillFileHeader header;
  header.magic = kSpillMagic;
  header.voxel_m = contents_.voxel_m;
  header.crc = CrcOfHeader(header);
  if (auto written = WriteAll(BytesOf(header)); !written) return written;
  contents_.committed_bytes = end_;
  return {};
}

core::Expected<void> SpillFile::WriteRecord(std::uint32_t magic, const TileIndex& tile,
                                            std::span<const std::uint8_t> payload) {
  if (payload.size() > std::numeric_limits<std::uint32_t>::max())
    return core::Fail(core::ErrorCode::kFull, path_ + ": a tile of more than 4 GB");
  SpillRecordHeader header;
  header.magic = magic;
  header.x = tile.x;
  header.y = tile.y;
  header.payload_bytes = static_cast<std::uint32_t>(payload.size());
  header.payload_crc = Crc32(payload);
  header.crc = CrcOfHeader(header);
  const std::uint64_t begin = end_;
  auto written = WriteAll(BytesOf(header));
  if (written) written = WriteAll(payload);
  if (!written) {
    end_ = begin;  // a full disk: the next record goes over the torn one
    return written;
  }
  if (magic == kSpillTileMagic)
    contents_.tiles[tile] = {begin + sizeof(header), header.payload_bytes, header.payload_crc};
  return {};
}

core::Expected<void> SpillFile::Append(const TileIndex& tile,
                                       std::span<const std::uint8_t> payload) {
  return WriteRecord(kSpillTileMagic, tile, payload);
}

core::Expected<void> SpillFile::Commit(std::uint64_t progress, std::uint64_t pictures) {
  // Tiles first, then the word that they count: a power cut may keep writes in any order.
  if (::fdatasync(fd_) != 0) return Errno("fsync");
  const SpillCommit commit{progress, pictures};
  if (auto written = WriteRecord(kSpillCommitMagic, {}, BytesOf(commit)); !written) return written;
  if (::fdatasync(fd_) != 0) return Errno("fsync");
  contents_.progress = progress;
  contents_.pictures = pictures;
  contents_.committed_bytes = end_;
  constexpr std::uint64_t kWorthIt = 64U << 20;
  const std::uint64_t live = live_bytes();
  if (end_ - live > kWorthIt && end_ - live > live) return Compact();
  return {};
}

std::uint64_t SpillFile::live_bytes() const {
  std::uint64_t live = 0;
  for (const auto& [tile, place] : contents_.tiles)
    live += place.payload_bytes + sizeof(SpillRecordHeader);
  return live;
}

core::Expected<void> SpillFile::Compact() {
  SpillFile fresh;
  fresh.path_ = path_ + ".part";
  fresh.contents_.voxel_m = contents_.voxel_m;
  fresh.fd_ = ::open(fresh.path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fresh.fd_ < 0) return fresh.Errno("create");
  if (auto written = fresh.WriteHeader(); !written) return written;
  for (const auto& [tile, place] : contents_.tiles) {
    auto payload = Read(tile);
    if (!payload) return tl::unexpected(payload.error());
    if (auto written = fresh.Append(tile, *payload); !written) return written;
  }
  // The recursion ends here: nothing in the fresh file has been replaced.
  if (auto done = fresh.Commit(contents_.progress, contents_.pictures); !done) return done;
  if (::rename(fresh.path_.c_str(), path_.c_str()) != 0) return Errno("rename to");
  SyncFolderOf(path_);
  fresh.path_ = path_;
  fresh.contents_.damaged_records = contents_.damaged_records;
  *this = std::move(fresh);
  return {};
}

core::Expected<std::vector<std::uint8_t>> SpillFile::Read(const TileIndex& tile) const {
  const auto found = contents_.tiles.find(tile);
  if (found == contents_.tiles.end())
    return core::Fail(core::ErrorCode::kNotFound, path_ + ": no such tile");
  const SpillContents::Place& place = found->second;
  std::vector<std::uint8_t> payload(place.payload_bytes);
  std::size_t done = 0;
  while (done < payload.size()) {
    const ssize_t n = ::pread(fd_, payload.data() + done, payload.size() - done,
                              static_cast<off_t>(place.payload_offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Errno("read");
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  if (done < payload.size() || Crc32(payload) != place.payload_crc)
    return core::Fail(core::ErrorCode::kFormat, path_ + ": tile " + std::to_string(tile.x) + "," +
                                                    std::to_string(tile.y) +
                                                    " was damaged on the disk");
  return payload;
}

}  // namespace kawara::vision
