#include "sim/camera/folder_pictures.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace kawara::sim {
namespace {

/// Width and height from the SOF segment (ITU-T T.81, B.2.2); false if there is none.
bool FindSize(Picture& picture) {
  const std::vector<std::uint8_t>& b = picture.jpeg;
  if (b.size() < 4 || b[0] != 0xFF || b[1] != 0xD8) return false;
  for (std::size_t i = 2; i + 9 < b.size();) {
    if (b[i] != 0xFF) return false;
    const unsigned marker = b[i + 1];
    if (marker == 0xFF) {  // fill byte
      ++i;
      continue;
    }
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) {
      picture.height = static_cast<std::uint32_t>((b[i + 5] << 8) | b[i + 6]);
      picture.width = static_cast<std::uint32_t>((b[i + 7] << 8) | b[i + 8]);
      return picture.width > 0 && picture.height > 0;
    }
    i += 2 + static_cast<std::size_t>((b[i + 2] << 8) | b[i + 3]);
  }
  return false;
}

}  // namespace

core::Expected<Picture> ReadJpegFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  Picture picture;
  picture.jpeg.assign(std::istreambuf_iterator<char>(in), {});
  if (!in) return core::Fail(core::ErrorCode::kIo, "read " + file.string() + ": failed");
  if (!FindSize(picture))
    return core::Fail(core::ErrorCode::kFormat, file.string() + ": not a JPEG picture");
  return picture;
}

core::Expected<FolderPictures> FolderPictures::Open(const std::filesystem::path& folder) {
  FolderPictures pictures;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".jpg" || extension == ".jpeg") pictures.files_.push_back(entry.path());
  }
  if (error)
    return core::Fail(core::ErrorCode::kNotFound, folder.string() + ": " + error.message());
  if (pictures.files_.empty()) {
    return core::Fail(core::ErrorCode::kNotFound,
                      folder.string() + ": holds no .jpg or .jpeg file");
  }
  std::sort(pictures.files_.begin(), pictures.files_.end());
  for (const auto& file : pictures.files_) {
    const core::Expected<Picture> picture = ReadJpegFile(file);
    if (!picture) return tl::unexpected(picture.error());
  }
  return pictures;
}

core::Expected<Picture> FolderPictures::Expose(const Caption& /*caption*/) {
  const std::filesystem::path& file = files_[next_];
  next_ = (next_ + 1) % files_.size();
  return ReadJpegFile(file);
}

}  // namespace kawara::sim
