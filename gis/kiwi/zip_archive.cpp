#include "gis/kiwi/zip_archive.hpp"

#include <zlib.h>

#include <limits>

namespace kawara::gis {
namespace {

constexpr std::uint32_t kLocalHeader = 0x04034b50, kDirectoryHeader = 0x02014b50,
                        kDirectoryEnd = 0x06054b50;
constexpr std::uint16_t kVersion = 20;  // 2.0: folders
constexpr std::uint16_t kUtf8Name = 1U << 11U;
constexpr std::uint16_t kEpochDate = (1U << 5U) | 1U;  // 1980-01-01

void Append16(std::string& bytes, std::uint32_t value) {
  bytes += static_cast<char>(value & 0xffU);
  bytes += static_cast<char>(value >> 8U & 0xffU);
}
void Append32(std::string& bytes, std::uint32_t value) {
  Append16(bytes, value & 0xffffU);
  Append16(bytes, value >> 16U);
}

/// What the local header and the directory say alike.
void AppendFacts(std::string& bytes, std::uint32_t crc, std::uint32_t size, std::size_t name) {
  Append16(bytes, kVersion);
  Append16(bytes, kUtf8Name);
  Append16(bytes, 0);  // stored
  Append16(bytes, 0);  // midnight
  Append16(bytes, kEpochDate);
  Append32(bytes, crc);
  Append32(bytes, size);
  Append32(bytes, size);
  Append16(bytes, static_cast<std::uint32_t>(name));
  Append16(bytes, 0);  // no extra field
}

}  // namespace

core::Expected<void> ZipArchive::Add(const std::string& name, std::string_view bytes) {
  constexpr std::size_t kMaxBytes = std::numeric_limits<std::uint32_t>::max();
  constexpr std::size_t kHeaders = 200;  // both of an entry and the end, rounded up
  constexpr std::uint32_t kMaxCount = 65534;
  const std::size_t total =
      entries_.size() + directory_.size() + bytes.size() + 2 * name.size() + kHeaders;
  if (total > kMaxBytes || name.size() > 65535 || count_ == kMaxCount)
    return core::Fail(core::ErrorCode::kFull, name + ": more than a ZIP archive holds");
  const auto* data = reinterpret_cast<const Bytef*>(bytes.data());
  const auto crc = static_cast<std::uint32_t>(crc32_z(0, data, bytes.size()));
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const auto offset = static_cast<std::uint32_t>(entries_.size());
  Append32(entries_, kLocalHeader);
  AppendFacts(entries_, crc, size, name.size());
  entries_ += name;
  entries_ += bytes;

  Append32(directory_, kDirectoryHeader);
  Append16(directory_, kVersion);
  AppendFacts(directory_, crc, size, name.size());
  Append16(directory_, 0);  // no comment
  Append16(directory_, 0);  // first disk
  Append16(directory_, 0);  // internal attributes: binary
  Append32(directory_, 0);  // external attributes: none
  Append32(directory_, offset);
  directory_ += name;
  ++count_;
  return {};
}

std::string ZipArchive::Finish() const {
  std::string file = entries_ + directory_;
  Append32(file, kDirectoryEnd);
  Append16(file, 0);
  Append16(file, 0);
  Append16(file, count_);
  Append16(file, count_);
  Append32(file, static_cast<std::uint32_t>(directory_.size()));
  Append32(file, static_cast<std::uint32_t>(entries_.size()));
  Append16(file, 0);
  return file;
}

}  // namespace kawara::gis
