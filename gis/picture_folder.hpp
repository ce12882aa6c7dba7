#pragma once
#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::gis {

/// JPEG files that are either whole and durable under their name, or not there. A batch: Stage()
/// writes each picture to a hidden temporary file in its folder, Commit() makes all of them durable
/// (fsync of each file, rename, fsync of each folder), Abort() takes the staged ones away again. A
/// row that names a picture is committed after Commit() has returned. One thread only.
class PictureFolder {
 public:
  /// Creates the folder (durably) and removes temporary files that a killed writer left.
  static core::Expected<PictureFolder> Open(const std::filesystem::path& folder);
  PictureFolder(PictureFolder&& other) noexcept;
  PictureFolder& operator=(PictureFolder&& other) noexcept;
  ~PictureFolder();  ///< Abort()

  /// `relative`: "robot/mission/000001.jpg"; folders on the way are made. Errors: kFull,
  /// kPermission, kIo.
  core::Expected<void> Stage(const std::string& relative, std::span<const std::uint8_t> bytes);
  core::Expected<void> Commit();
  void Abort();

  const std::filesystem::path& path() const { return folder_; }

 private:
  struct Staged {
    int fd = -1;
    std::filesystem::path temporary;
    std::filesystem::path final;
  };
  explicit PictureFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  core::Expected<void> Prepare(const std::filesystem::path& parent);

  std::filesystem::path folder_;
  std::vector<Staged> staged_;
  std::set<std::filesystem::path> durable_;  ///< folders known to survive a power cut
};

/// mkdir -p; every folder made, and the last one in any case, is durable (fsync of its parent).
core::Expected<void> MakeFolders(const std::filesystem::path& folder);
core::Expected<void> SyncFolder(const std::filesystem::path& folder);

}  // namespace kawara::gis
