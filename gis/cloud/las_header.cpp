#include "gis/cloud/las_header.hpp"

#include <bit>
#include <cstring>
#include <string_view>

namespace kawara::gis {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint64_t kMostRecords = 100'000;
constexpr std::uint64_t kMostRecordBytes = 1U << 24U;  // of those that are read
// Smallest length of point formats 0 to 10.
constexpr std::uint16_t kPointBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

template <class T>
T At(std::span<const std::uint8_t> bytes, std::size_t offset) {
  T value{};
  if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::string TextAt(std::span<const std::uint8_t> bytes, std::size_t offset, std::size_t most) {
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()) + offset,
                             std::min(most, bytes.size() - offset));
  return std::string(all.substr(0, all.find('\0')));
}

tl::unexpected<core::Error> Wrong(const ByteSource& source, const std::string& what) {
  return core::Fail(core::ErrorCode::kFormat, source.name() + ": " + what);
}

tl::unexpected<core::Error> Compressed(const ByteSource& source) {
  return Wrong(source,
               "is LAZ (compressed LAS), which is not read: unpack it with \"laszip -i FILE.laz -o "
               "FILE.las\" or \"pdal translate FILE.laz FILE.las\"");
}

/// What the records say of the reference system.
struct CrsRecords {
  std::string wkt, keys, doubles, text;
  bool is_compressed = false;
};

/// Records one after the other from where the source stands. `extended`: those after the points.
/// False: they leave the file.
bool ReadRecords(ByteSource& source, std::uint64_t count, bool extended, CrsRecords& records) {
  const std::size_t head_bytes = extended ? 60 : 54;
  for (std::uint64_t i = 0; i < std::min(count, kMostRecords); ++i) {
    const auto head = source.Peek(head_bytes);
    if (head.size() < head_bytes) return false;
    const std::string user = TextAt(head.first(head_bytes), 2, 16);
    const auto id = At<std::uint16_t>(head, 18);
    const std::uint64_t length =
        extended ? At<std::uint64_t>(head, 20) : At<std::uint16_t>(head, 20);
    source.Take(head_bytes);
    std::string* wanted = nullptr;
    if (user == "LASF_Projection") {
      if (id == 2112) wanted = &records.wkt;
      if (id == 34735) wanted = &records.keys;
      if (id == 34736) wanted = &records.doubles;
      if (id == 34737) wanted = &records.text;
    }
    if (user == "laszip encoded") records.is_compressed = true;
    if (wanted == nullptr || length > kMostRecordBytes) {
      if (!source.Skip(length)) return false;
      continue;
    }
    const auto bytes = source.Peek(static_cast<std::size_t>(length));
    if (bytes.size() < length) return false;
    wanted->assign(reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(length));
    source.Take(static_cast<std::size_t>(length));
  }
  return true;
}

}  // namespace

core::Expected<LasHeader> ReadLasHeader(ByteSource& source) {
  constexpr std::size_t kOldHeaderBytes = 227, kHeaderBytes = 375;
  const auto bytes = source.Peek(kHeaderBytes);
  if (bytes.size() < 4 || TextAt(bytes, 0, 4) != "LASF") return Wrong(source, "no LAS file");
  if (bytes.size() < kOldHeaderBytes) return Wrong(source, "ends within its header (cut off?)");
  LasHeader h;
  h.minor = bytes[25];
  if (bytes[24] != 1 || h.minor > 4)
    return Wrong(source, "is LAS " + std::to_string(bytes[24]) + "." + std::to_string(h.minor) +
                             ", known are 1.0 to 1.4");
  const auto header_bytes = At<std::uint16_t>(bytes, 94);
  const std::size_t least = h.minor < 3 ? kOldHeaderBytes : h.minor == 3 ? 235 : kHeaderBytes;
  if (header_bytes < least || bytes.size() < least)
    return Wrong(source, "a header of " + std::to_string(header_bytes) + " bytes, LAS 1." +
                             std::to_string(h.minor) + " has " + std::to_string(least));
  h.points_at = At<std::uint32_t>(bytes, 96);
  const auto records = At<std::uint32_t>(bytes, 100);
  h.format = bytes[104];
  h.record_bytes = At<std::uint16_t>(bytes, 105);
  h.points = At<std::uint32_t>(bytes, 107);
  for (Eigen::Index k = 0; k < 3; ++k) {
    h.scale[k] = At<double>(bytes, 131 + 8 * static_cast<std::size_t>(k));
    h.offset[k] = At<double>(bytes, 155 + 8 * static_cast<std::size_t>(k));
    h.high[k] = At<double>(bytes, 179 + 16 * static_cast<std::size_t>(k));
    h.low[k] = At<double>(bytes, 187 + 16 * static_cast<std::size_t>(k));
  }
  std::uint64_t extended_at = 0, extended = 0;
  if (h.minor == 4) {
    extended_at = At<std::uint64_t>(bytes, 235);
    extended = At<std::uint32_t>(bytes, 243);
    // Some writers of 1.4 fill the old count only.
    if (const auto points = At<std::uint64_t>(bytes, 247); points != 0) h.points = points;
  }
  if ((h.format & 0xC0U) != 0) return Compressed(source);
  if (h.format > 10)
    return Wrong(source, "point format " + std::to_string(h.format) + ", known are 0 to 10");
  if (h.record_bytes < kPointBytes[h.format])
    return Wrong(source, "points of " + std::to_string(h.record_bytes) + " bytes, format " +
                             std::to_string(h.format) + " has at least " +
                             std::to_string(kPointBytes[h.format]));
  if (!h.scale.allFinite() || !h.offset.allFinite() || (h.scale.array() == 0.0).any())
    return Wrong(source, "its scale or offset is no number");
  if (h.points_at < header_bytes)
    return Wrong(source,
                 "its points begin within its header, at byte " + std::to_string(h.points_at));

  CrsRecords crs;
  if (!source.Seek(header_bytes) || !ReadRecords(source, records, false, crs))
    return Wrong(source, "ends within its variable length records (cut off?)");
  if (crs.is_compressed) return Compressed(source);
  // Those behind the points: the points are whole without them, and a file that is cut off says so
  // when its points are read.
  if (crs.wkt.empty() && extended > 0 && source.Seek(extended_at))
    (void)ReadRecords(source, extended, true, crs);
  h.crs = crs.wkt.substr(0, crs.wkt.find('\0'));
  if (h.crs.empty() && !crs.keys.empty()) h.crs = CrsOfGeoKeys(crs.keys, crs.doubles, crs.text);
  return h;
}

}  // namespace kawara::gis
