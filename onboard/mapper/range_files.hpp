#pragma once
#include <filesystem>

#include "core/expected.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::mapper {

/// What a distance image becomes in a folder. Every file is there whole or not at all.
struct RangeFiles {
  std::filesystem::path
      range_png;                 ///< 16 bits: millimetres; 0 unknown, 65535 farther than 65.534 m
  std::filesystem::path sd_png;  ///< 16 bits: tenths of a millimetre; 0 unknown, 65535 more
  std::filesystem::path range_pfm;  ///< floats in metres, NaN unknown, little-endian
  std::filesystem::path sd_pfm;     ///< the same
  std::filesystem::path view_png;   ///< for people: near red, far blue, black unknown
};

/// NAME.range.png, NAME.sd.png, NAME.range.pfm, NAME.sd.pfm and NAME.view.png in `folder`, which
/// exists. Errors: kIo, kPermission, kFull.
core::Expected<RangeFiles> WriteRangeFiles(const vision::RangeImage& ranges,
                                           const std::filesystem::path& folder,
                                           const std::string& name);

}  // namespace kawara::mapper
