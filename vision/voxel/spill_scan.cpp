#include <cmath>
#include <cstring>
#include <optional>

#include "vision/voxel/spill_file.hpp"
#include "vision/voxel/spill_record.hpp"

namespace kawara::vision {
namespace {

/// Header of a record that lies whole in `bytes` at `at`, if one is there.
std::optional<SpillRecordHeader> HeaderAt(std::span<const std::uint8_t> bytes, std::size_t at) {
  SpillRecordHeader header;
  if (bytes.size() - at < sizeof(header)) return std::nullopt;
  std::memcpy(&header, bytes.data() + at, sizeof(header));
  if (header.magic != kSpillTileMagic && header.magic != kSpillCommitMagic) return std::nullopt;
  if (header.crc != CrcOfHeader(header)) return std::nullopt;
  if (bytes.size() - at - sizeof(header) < header.payload_bytes) return std::nullopt;
  return header;
}

}  // namespace

core::Expected<SpillContents> ScanSpill(std::span<const std::uint8_t> bytes) {
  SpillFileHeader file;
  if (bytes.size() < sizeof(file))
    return core::Fail(core::ErrorCode::kFormat, "too short for a voxel spill file");
  std::memcpy(&file, bytes.data(), sizeof(file));
  if (file.magic != kSpillMagic)
    return core::Fail(core::ErrorCode::kFormat, "no voxel spill file of this version");
  if (file.crc != CrcOfHeader(file) || !std::isfinite(file.voxel_m) || !(file.voxel_m > 0.0))
    return core::Fail(core::ErrorCode::kFormat, "damaged header of a voxel spill file");

  // `committed` follows `current` at each commit.
  SpillContents current, committed;
  committed.voxel_m = current.voxel_m = file.voxel_m;
  committed.committed_bytes = sizeof(file);
  std::size_t at = sizeof(file);
  bool in_damage = false;
  while (at < bytes.size()) {
    const auto header = HeaderAt(bytes, at);
    if (!header) {
      if (!in_damage) ++current.damaged_records;
      in_damage = true;
      ++at;
      continue;
    }
    in_damage = false;
    const std::size_t payload_at = at + sizeof(SpillRecordHeader);
    const auto payload = bytes.subspan(payload_at, header->payload_bytes);
    at = payload_at + header->payload_bytes;
    if (Crc32(payload) != header->payload_crc) {
      ++current.damaged_records;
      continue;
    }
    if (header->magic == kSpillTileMagic) {
      current.tiles[{header->x, header->y}] = {payload_at, header->payload_bytes,
                                               header->payload_crc};
      continue;
    }
    SpillCommit commit;
    if (payload.size() != sizeof(commit)) {
      ++current.damaged_records;
      continue;
    }
    std::memcpy(&commit, payload.data(), sizeof(commit));
    current.progress = commit.progress;
    current.pictures = commit.pictures;
    current.committed_bytes = at;
    committed = current;
  }
  return committed;
}

}  // namespace kawara::vision
