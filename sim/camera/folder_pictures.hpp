#pragma once
#include <filesystem>
#include <vector>

#include "sim/camera/picture_source.hpp"

namespace kawara::sim {

/// JPEG files of a folder in the order of their names, from the first again after the last; as they
/// are, without caption. One thread.
class FolderPictures final : public PictureSource {
 public:
  /// kNotFound: no folder, or no .jpg/.jpeg file in it; kFormat: a file that is no JPEG.
  static core::Expected<FolderPictures> Open(const std::filesystem::path& folder);
  void Prepare(core::GpsTime /*expected*/) override {}
  core::Expected<Picture> Expose(const Caption& caption) override;
  std::size_t size() const { return files_.size(); }

 private:
  std::vector<std::filesystem::path> files_;
  std::size_t next_ = 0;
};

/// Reads one JPEG file and its size in pixels from its frame header.
core::Expected<Picture> ReadJpegFile(const std::filesystem::path& file);

}  // namespace kawara::sim
