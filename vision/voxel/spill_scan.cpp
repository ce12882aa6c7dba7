#include <cmath>
#include <cstring>
#include <fstream>
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

core::Expected<double> VoxelOfHeader(std::span<const std::uint8_t> bytes) {
  SpillFileHeader file;
  if (bytes.size() < sizeof(file))
    return core::Fail(core::ErrorCode::kFormat, "too short for a voxel spill file");
  std::memcpy(&file, bytes.data(), sizeof(file));
  if (file.magic != kSpillMagic)
    return core::Fail(core::ErrorCode::kFormat, "no voxel spill file of this version");
  if (file.crc != CrcOfHeader(file) || !std::isfinite(file.voxel_m) || !(file.voxel_m > 0.0))
    return core::Fail(core::ErrorCode::kFormat, "damaged header of a voxel spill file");
  return file.voxel_m;
}

}  // namespace

core::Expected<double> SpillFile::VoxelOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return core::Fail(core::ErrorCode::kNotFound, path + ": cannot be opened");
  std::array<std::uint8_t, sizeof(SpillFileHeader)> bytes{};
  in.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
  auto voxel_m = VoxelOfHeader({bytes.data(), static_cast<std::size_t>(in.gcount())});
  if (!voxel_m) return core::Fail(voxel_m.error().code, path + ": " + voxel_m.error().message);
  return voxel_m;
}

core::Expected<SpillContents> ScanSpill(std::span<const std::uint8_t> bytes) {
  const auto voxel_m = VoxelOfHeader(bytes);
  if (!voxel_m) return tl::unexpected(voxel_m.error());

  // `committed` follows `current` at each commit.
  SpillContents current, committed;
  committed.voxel_m = current.voxel_m = *voxel_m;
  committed.committed_bytes = sizeof(SpillFileHeader);
  std::size_t at = sizeof(SpillFileHeader);
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
