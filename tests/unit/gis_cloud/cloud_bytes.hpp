#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "gis/cloud/cloud.hpp"

/// Files made byte by byte, for the readers of clouds.
namespace kawara::gis {

template <class T>
void Put(std::string& bytes, T value) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}
template <class T>
void PutBig(std::string& bytes, T value) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.rbegin(), raw.rend());
}
template <class T>
void SetAt(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

inline std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
inline std::string WriteTo(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

/// All points, and what came back.
struct WholeCloud {
  std::vector<CloudPoint> points;
  core::Expected<CloudInfo> info;
};
inline WholeCloud ReadAll(const std::string& path, const CloudReadOptions& options = {}) {
  WholeCloud all;
  all.info = ReadCloud(
      path,
      [&all](std::span<const CloudPoint> chunk) {
        all.points.insert(all.points.end(), chunk.begin(), chunk.end());
      },
      options);
  return all;
}
inline WholeCloud ReadAllEnu(const std::string& path, const MapFrame& frame) {
  WholeCloud all;
  all.info = ReadCloudEnu(path, frame, [&all](std::span<const CloudPoint> chunk) {
    all.points.insert(all.points.end(), chunk.begin(), chunk.end());
  });
  return all;
}

struct LasRecord {
  std::string user;
  std::uint16_t id = 0;
  std::string bytes;
};
/// A LAS file of `count` points at (i, 2 i, 3 i) raw, times 0.01, from (1000, 2000, 30); colours
/// `i * colour_step`, intensity 7 i, time 100 + i, class 2.
struct LasRecipe {
  int minor = 2;
  std::uint8_t format = 0;
  std::uint32_t count = 3;
  std::uint16_t extra_bytes = 0;
  std::uint16_t colour_step = 257;
  std::vector<LasRecord> records;
  std::vector<LasRecord> extended;  ///< minor 4
};
inline std::string MakeLas(const LasRecipe& recipe) {
  constexpr std::array<std::uint16_t, 11> kBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  const std::size_t header = recipe.minor < 3 ? 227 : recipe.minor == 3 ? 235 : 375;
  const auto record_bytes = static_cast<std::uint16_t>(kBytes[recipe.format] + recipe.extra_bytes);
  std::string records;
  for (const LasRecord& r : recipe.records) {
    Put<std::uint16_t>(records, 0);
    std::string user = r.user;
    user.resize(16, '\0');
    records += user;
    Put(records, r.id);
    Put(records, static_cast<std::uint16_t>(r.bytes.size()));
    records.append(32, '\0');
    records += r.bytes;
  }
  std::string las(header, '\0');
  las.replace(0, 4, "LASF");
  las[24] = 1;
  las[25] = static_cast<char>(recipe.minor);
  SetAt(las, 94, static_cast<std::uint16_t>(header));
  SetAt(las, 96, static_cast<std::uint32_t>(header + records.size()));
  SetAt(las, 100, static_cast<std::uint32_t>(recipe.records.size()));
  SetAt(las, 104, recipe.format);
  SetAt(las, 105, record_bytes);
  SetAt(las, 107, recipe.format < 6 ? recipe.count : 0U);
  for (std::size_t k = 0; k < 3; ++k) SetAt(las, 131 + 8 * k, 0.01);
  SetAt(las, 155, 1000.0);
  SetAt(las, 163, 2000.0);
  SetAt(las, 171, 30.0);
  las += records;
  for (std::uint32_t i = 0; i < recipe.count; ++i) {
    std::string p(record_bytes, '\0');
    for (std::uint32_t k = 0; k < 3; ++k) SetAt(p, 4 * k, static_cast<std::int32_t>((k + 1) * i));
    SetAt(p, 12, static_cast<std::uint16_t>(7 * i));
    p[recipe.format < 6 ? 15 : 16] = 2;
    const std::size_t time = recipe.format >= 6                         ? 22
                             : recipe.format == 0 || recipe.format == 2 ? 0
                                                                        : 20;
    if (time > 0) SetAt(p, time, 100.0 + i);
    constexpr std::array<std::size_t, 11> kColour{0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
    for (std::size_t k = 0; kColour[recipe.format] > 0 && k < 3; ++k)
      SetAt(p, kColour[recipe.format] + 2 * k, static_cast<std::uint16_t>(recipe.colour_step * i));
    las += p;
  }
  if (recipe.minor == 4) {
    SetAt(las, 247, std::uint64_t{recipe.count});
    SetAt(las, 235, std::uint64_t{las.size()});
    SetAt(las, 243, static_cast<std::uint32_t>(recipe.extended.size()));
    for (const LasRecord& r : recipe.extended) {
      Put<std::uint16_t>(las, 0);
      std::string user = r.user;
      user.resize(16, '\0');
      las += user;
      Put(las, r.id);
      Put(las, std::uint64_t{r.bytes.size()});
      las.append(32, '\0');
      las += r.bytes;
    }
  }
  return las;
}

}  // namespace kawara::gis
