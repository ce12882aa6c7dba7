#include "sim/render/light_cache.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "sim/render/light_field.hpp"

namespace kawara::sim {
namespace {

namespace fs = std::filesystem;

/// Raise it when LightField measures in another way.
constexpr std::uint64_t kVersion = 1;
constexpr char kSuffix[] = ".light";

/// A digest of a sequence of numbers. Source of the mixing: the finalizer of SplitMix64.
class Digest {
 public:
  template <class Number>
  void Add(Number x) {
    static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
    std::uint64_t word = 0;
    std::memcpy(&word, &x, sizeof x);
    Mix(word);
  }
  void Add(const Eigen::Vector3f& v) {
    for (int axis = 0; axis < 3; ++axis) Add(v[axis]);
  }
  void Add(const std::string& bytes) {
    Add(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i, std::min(sizeof word, bytes.size() - i));
      Mix(word);
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  void Mix(std::uint64_t word) {
    std::uint64_t z = value_ + 0x9e3779b97f4a7c15ULL + word;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    value_ = z ^ (z >> 31) ^ (word << 1);
  }
  std::uint64_t value_ = kVersion;
};

std::uint64_t DigestOf(std::uint64_t key, const std::string& bytes) {
  Digest digest;
  digest.Add(key);
  digest.Add(bytes);
  return digest.value();
}

}  // namespace

fs::path LightCache::FileOf(std::uint64_t key) const {
  char name[32];
  std::snprintf(name, sizeof name, "%016llx%s", static_cast<unsigned long long>(key), kSuffix);
  return folder_ / name;
}

std::optional<std::string> LightCache::Load(std::uint64_t key) const {
  if (folder_.empty()) return {};
  std::ifstream file(FileOf(key), std::ios::binary);
  if (!file) return {};
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::uint64_t digest = 0;
  if (!file || bytes.size() < sizeof digest) return {};
  const std::size_t size = bytes.size() - sizeof digest;
  std::memcpy(&digest, bytes.data() + size, sizeof digest);
  bytes.resize(size);
  if (digest != DigestOf(key, bytes)) return {};
  return bytes;
}

void LightCache::Save(std::uint64_t key, const std::string& bytes) const {
  if (folder_.empty()) return;
  std::error_code error;
  fs::create_directories(folder_, error);
  const fs::path fresh = FileOf(key).string() + "." + std::to_string(::getpid());
  {
    std::ofstream file(fresh, std::ios::binary | std::ios::trunc);
    const std::uint64_t digest = DigestOf(key, bytes);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.write(reinterpret_cast<const char*>(&digest), sizeof digest);
    file.close();
    if (file) fs::rename(fresh, FileOf(key), error);
    if (!file || error) fs::remove(fresh, error);
  }
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    if (entry.path().extension() == kSuffix) {
      files.emplace_back(entry.last_write_time(error), entry.path());
    }
  }
  std::sort(files.rbegin(), files.rend());
  for (std::size_t i = kMostFiles; i < files.size(); ++i) fs::remove(files[i].second, error);
}

std::uint64_t LightCache::KeyOf(const Scene& scene, const LightSettings& settings) {
  Digest digest;
  digest.Add(settings.sky_seed);
  digest.Add(settings.sky_columns);
  digest.Add(settings.cell_m);
  digest.Add(settings.max_points);
  digest.Add(scene.sun.azimuth_rad);
  digest.Add(scene.sun.elevation_rad);
  digest.Add(scene.sun.sky_share);
  for (const Material& material : scene.materials) {
    for (const float share : material.base_rgb) digest.Add(share);
  }
  for (const SceneObject& object : scene.objects) {
    digest.Add(object.id);
    digest.Add(object.cls);
    digest.Add(object.begin_s ? 1 : 0);
    digest.Add(object.begin_s.value_or(0.0));
    digest.Add(object.end_s ? 1 : 0);
    digest.Add(object.end_s.value_or(0.0));
  }
  for (const Mesh& mesh : scene.meshes) {
    digest.Add(mesh.object);
    digest.Add(mesh.material);
    digest.Add(mesh.vertices_m.size());
    digest.Add(mesh.triangles.size());
    for (const Eigen::Vector3f& vertex : mesh.vertices_m) digest.Add(vertex);
    for (const auto& corners : mesh.triangles) {
      for (const std::uint32_t corner : corners) digest.Add(corner);
    }
  }
  return digest.value();
}

fs::path LightCache::DefaultFolder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && fs::path(cache).is_absolute()) return fs::path(cache) / "kawaraban";
  const char* home = std::getenv("HOME");
  if (home != nullptr && fs::path(home).is_absolute()) return fs::path(home) / ".cache/kawaraban";
  return {};
}

}  // namespace kawara::sim
