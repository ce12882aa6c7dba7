#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/expected.hpp"
#include "vision/voxel/voxel.hpp"

namespace kawara::vision {

/// What a spill file's bytes say up to its last commit.
struct SpillContents {
  struct Place {
    std::uint64_t payload_offset = 0;
    std::uint32_t payload_bytes = 0;
    std::uint32_t payload_crc = 0;
  };
  double voxel_m = 0.0;
  std::map<TileIndex, Place> tiles;  ///< the newest record of each
  std::uint64_t progress = 0;        ///< the last commit's; 0 without one
  std::uint64_t pictures = 0;
  std::uint64_t committed_bytes =
      0;  ///< end of the last commit; everything after it does not count
  std::uint64_t damaged_records = 0;  ///< before that, left out
};

/// Reads records one after the other; after damage it goes on at the next whole one. Payloads are
/// checked by their CRC only. Errors: kFormat (no spill file, or another version).
core::Expected<SpillContents> ScanSpill(std::span<const std::uint8_t> bytes);

/// Journal of tiles on disk. A tile is appended as a record of its own (the newest counts); a
/// commit makes everything so far one consistent state that survives SIGKILL and power cut. What
/// was appended after the last commit is forgotten at the next Open: the state is then that of the
/// commit, so that going on from its `progress` counts nothing twice.
///
///   file    "KWSPILL1", double voxel_m, u32 0, CRC of these
///   record  u32 magic, i32 x, i32 y, u32 payload bytes, u32 payload CRC, CRC of these; payload
///   commit  the same with another magic; payload: u64 progress, u64 pictures
/// Little-endian, CRC-32 of zlib. One thread.
class SpillFile {
 public:
  /// Opens or creates. Errors: kFormat (another file, or other voxels), kIo, kPermission, kFull.
  static core::Expected<SpillFile> Open(const std::string& path, double voxel_m);
  SpillFile(SpillFile&& other) noexcept;
  SpillFile& operator=(SpillFile&& other) noexcept;
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;
  ~SpillFile();

  /// Side of the voxels of an existing file. Errors: kNotFound, kFormat.
  static core::Expected<double> VoxelOf(const std::string& path);

  core::Expected<void> Append(const TileIndex& tile, std::span<const std::uint8_t> payload);
  /// Durable on return. Rewrites the file when more than half of it, and more than 64 MB, is
  /// records that newer ones replaced. Errors as of Open.
  core::Expected<void> Commit(std::uint64_t progress, std::uint64_t pictures);
  /// Newest payload of a tile. Errors: kNotFound, kFormat (damaged since), kIo.
  core::Expected<std::vector<std::uint8_t>> Read(const TileIndex& tile) const;

  const SpillContents& contents() const { return contents_; }
  std::uint64_t bytes() const { return end_; }
  const std::string& path() const { return path_; }

 private:
  SpillFile() = default;
  core::Expected<void> Load();
  core::Expected<void> WriteHeader();
  core::Expected<void> WriteRecord(std::uint32_t magic, const TileIndex& tile,
                                   std::span<const std::uint8_t> payload);
  core::Expected<void> WriteAll(std::span<const std::uint8_t> bytes);
  core::Expected<void> Compact();
  std::uint64_t live_bytes() const;
  tl::unexpected<core::Error> Errno(const char* doing) const;

  std::string path_;
  int fd_ = -1;
  std::uint64_t end_ = 0;
  SpillContents contents_;
};

}  // namespace kawara::vision
