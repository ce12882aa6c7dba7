#include "vision/change/reference_file.hpp"

#include <zlib.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

namespace kawara::vision {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::array<char, 8> kMagic{'K', 'W', 'R', 'E', 'F', '0', '0', '1'};
constexpr std::size_t kBody = kMagic.size() + sizeof(std::uint32_t);

std::uint32_t Crc(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

class Writer {
 public:
  template <class T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    const auto raw = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  }
  void Text(const std::string& text) {
    Put(static_cast<std::uint32_t>(text.size()));
    bytes.insert(bytes.end(), text.begin(), text.end());
  }
  void Line(const std::vector<Eigen::Vector2d>& points) {
    Put(static_cast<std::uint32_t>(points.size()));
    for (const Eigen::Vector2d& p : points) {
      Put(p.x());
      Put(p.y());
    }
  }
  std::vector<std::uint8_t> bytes;
};

/// Once it has run out of bytes everything it gives is zero.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <class T>
  T Get() {
    std::array<std::uint8_t, sizeof(T)> raw{};
    if (bytes_.size() < sizeof(T)) {
      Fail();
    } else {
      std::memcpy(raw.data(), bytes_.data(), sizeof(T));
      bytes_ = bytes_.subspan(sizeof(T));
    }
    return std::bit_cast<T>(raw);
  }
  std::string Text() {
    const std::size_t size = Count<std::uint32_t>(1);
    std::string text(reinterpret_cast<const char*>(bytes_.data()), size);
    bytes_ = bytes_.subspan(size);
    return text;
  }
  std::vector<Eigen::Vector2d> Line() {
    std::vector<Eigen::Vector2d> points(Count<std::uint32_t>(2 * sizeof(double)));
    for (Eigen::Vector2d& p : points) {
      p.x() = Number();
      p.y() = Number();
    }
    return points;
  }
  /// How many things of at least so many bytes each follow.
  template <class T>
  std::size_t Count(std::size_t least_bytes) {
    const auto count = static_cast<std::uint64_t>(Get<T>());
    if (count > bytes_.size() / least_bytes) {
      Fail();
      return 0;
    }
    return static_cast<std::size_t>(count);
  }
  double Number() {
    const double value = Get<double>();
    if (!std::isfinite(value)) Fail();
    return value;
  }
  float Small() {
    const float value = Get<float>();
    if (!std::isfinite(value)) Fail();
    return value;
  }
  void Fail() {
    good_ = false;
    bytes_ = {};
  }
  bool good() const { return good_; }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
  bool good_ = true;
};

void PutPatch(Writer& out, const VoxelIndex& voxel, const ReferencePatch& patch) {
  for (const std::int32_t i : {voxel.x, voxel.y, voxel.z}) out.Put(i);
  for (const float v : patch.mean_m) out.Put(v);
  for (const float v : patch.normal) out.Put(v);
  out.Put(patch.thickness_m);
  out.Put(patch.sd_m);
  out.Put(patch.points);
  out.Put(patch.source);
}

void GetPatch(Reader& in, ReferenceMap& reference) {
  VoxelIndex voxel;
  for (std::int32_t* i : {&voxel.x, &voxel.y, &voxel.z}) *i = in.Get<std::int32_t>();
  ReferencePatch patch;
  for (float& v : patch.mean_m) v = in.Small();
  for (float& v : patch.normal) v = in.Small();
  patch.thickness_m = in.Small();
  patch.sd_m = in.Small();
  patch.points = in.Get<std::uint32_t>();
  patch.source = in.Get<std::uint16_t>();
  if (patch.source >= reference.sources.size() || patch.sd_m < 0.0F || patch.thickness_m < 0.0F)
    in.Fail();
  if (in.good()) reference.SetPatch(voxel, patch);
}

}  // namespace

std::vector<std::uint8_t> EncodeReference(const ReferenceMap& reference) {
  Writer out;
  const core::Geodetic origin = reference.origin.value_or(core::Geodetic{});
  out.Put(static_cast<std::uint8_t>(reference.origin ? 1 : 0));
  out.Put(origin.lat_rad * core::kDegFromRad);
  out.Put(origin.lon_rad * core::kDegFromRad);
  out.Put(origin.h_ellipsoidal_m);
  out.Put(ReferenceMap::kVoxel);
  out.Put(reference.ground.cell_m());
  out.Put(static_cast<std::uint32_t>(reference.sources.size()));
  for (const ReferenceSource& source : reference.sources) {
    out.Text(source.name);
    out.Text(source.kind);
    out.Put(source.date.ns());
    out.Put(source.sd_m);
  }
  out.Put(static_cast<std::uint64_t>(reference.patches()));
  for (const auto& [voxel, patch] : reference.Patches()) PutPatch(out, voxel, patch);
  const auto cells = reference.ground.Cells();
  out.Put(static_cast<std::uint64_t>(cells.size()));
  for (const auto& [cell, height] : cells) {
    out.Put(cell.first);
    out.Put(cell.second);
    out.Put(static_cast<float>(height.up_m));
    out.Put(static_cast<float>(height.sd_m));
  }
  out.Put(static_cast<std::uint32_t>(reference.roads.size()));
  for (const RoadPolygon& road : reference.roads) {
    out.Text(road.name);
    out.Put(static_cast<std::uint32_t>(1 + road.holes.size()));
    out.Line(road.outer);
    for (const auto& hole : road.holes) out.Line(hole);
  }
  out.Put(static_cast<std::uint32_t>(reference.road_axes.size()));
  for (const auto& [name, points] : reference.road_axes) {
    out.Text(name);
    out.Line(points);
  }
  Writer file;
  for (const char c : kMagic) file.Put(c);
  file.Put(Crc(out.bytes));
  file.bytes.insert(file.bytes.end(), out.bytes.begin(), out.bytes.end());
  return std::move(file.bytes);
}

core::Expected<ReferenceMap> DecodeReference(std::span<const std::uint8_t> bytes) {
  const auto wrong = [](const char* what) { return core::Fail(core::ErrorCode::kFormat, what); };
  if (bytes.size() < kBody || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return wrong("no reference of kawara-reference");
  std::uint32_t crc = 0;
  std::memcpy(&crc, bytes.data() + kMagic.size(), sizeof(crc));
  if (crc != Crc(bytes.subspan(kBody))) return wrong("damaged (its checksum does not fit)");
  Reader in(bytes.subspan(kBody));
  ReferenceMap reference;
  const bool has_origin = in.Get<std::uint8_t>() != 0;
  core::Geodetic origin;
  origin.lat_rad = in.Number() * core::kRadFromDeg;
  origin.lon_rad = in.Number() * core::kRadFromDeg;
  origin.h_ellipsoidal_m = in.Number();
  if (has_origin) reference.origin = origin;
  if (in.Number() != ReferenceMap::kVoxel) return wrong("made with other voxels than 0.5 m");
  const double cell_m = in.Number();
  if (!(cell_m > 0.01 && cell_m < 100.0)) return wrong("cells of its ground of no size");
  reference.ground = GroundField(cell_m);
  for (std::size_t n = in.Count<std::uint32_t>(24); n > 0 && in.good(); --n) {
    ReferenceSource source;
    source.name = in.Text();
    source.kind = in.Text();
    source.date = core::UtcTime::FromNs(in.Get<std::int64_t>());
    source.sd_m = in.Number();
    reference.sources.push_back(std::move(source));
  }
  constexpr std::size_t kPatchBytes = 50, kCellBytes = 16;
  const auto patches = in.Count<std::uint64_t>(kPatchBytes);
  reference.Reserve(patches);
  for (std::size_t n = patches; n > 0 && in.good(); --n) GetPatch(in, reference);
  for (std::size_t n = in.Count<std::uint64_t>(kCellBytes); n > 0 && in.good(); --n) {
    const auto x = in.Get<std::int32_t>(), y = in.Get<std::int32_t>();
    const float up = in.Small(), sd = in.Small();
    reference.ground.Set({x, y}, {static_cast<double>(up), static_cast<double>(sd)});
  }
  for (std::size_t n = in.Count<std::uint32_t>(8); n > 0 && in.good(); --n) {
    RoadPolygon road;
    road.name = in.Text();
    const auto rings = in.Count<std::uint32_t>(4);
    for (std::size_t i = 0; i < rings && in.good(); ++i) {
      auto line = in.Line();
      if (i == 0)
        road.outer = std::move(line);
      else
        road.holes.push_back(std::move(line));
    }
    reference.roads.push_back(std::move(road));
  }
  for (std::size_t n = in.Count<std::uint32_t>(8); n > 0 && in.good(); --n) {
    std::string name = in.Text();
    reference.road_axes.emplace_back(std::move(name), in.Line());
  }
  if (!in.good() || !in.empty()) return wrong("its parts contradict each other");
  return reference;
}

bool IsReferenceFile(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::array<char, kMagic.size()> head{};
  in.read(head.data(), head.size());
  return in && head == kMagic;
}

core::Expected<ReferenceMap> ReadReference(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    const int why = errno;
    return core::Fail(why == EACCES ? core::ErrorCode::kPermission : core::ErrorCode::kNotFound,
                      path.string() + ": cannot be opened: " + std::strerror(why));
  }
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  auto reference =
      DecodeReference({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  if (!reference)
    return core::Fail(reference.error().code, path.string() + ": " + reference.error().message);
  return reference;
}

}  // namespace kawara::vision
