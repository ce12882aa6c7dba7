#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "sim/site/scene.hpp"

namespace kawara::sim {

struct LightSettings;

/// Measured light kept between runs: files named after all the light depends on, so that a changed
/// site is measured anew. A convenience: what cannot be read, is damaged or cannot be written is as
/// if it were not there. A file appears whole; any number of programs share a folder.
class LightCache {
 public:
  /// An empty folder: keeps nothing.
  explicit LightCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<std::string> Load(std::uint64_t key) const;
  /// The least recently written beyond kMostFiles are removed.
  void Save(std::uint64_t key, const std::string& bytes) const;

  /// Of everything that says what light there is.
  static std::uint64_t KeyOf(const Scene& scene, const LightSettings& settings);
  /// $XDG_CACHE_HOME/kawaraban or ~/.cache/kawaraban; empty if there is neither.
  static std::filesystem::path DefaultFolder();

  static constexpr std::size_t kMostFiles = 16;

 private:
  std::filesystem::path FileOf(std::uint64_t key) const;
  std::filesystem::path folder_;
};

}  // namespace kawara::sim
