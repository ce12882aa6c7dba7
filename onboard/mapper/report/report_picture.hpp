#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "vision/image.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::mapper {

/// A picture as it goes into a page: a whole JPEG or PNG file. Empty bytes: there is none.
struct ReportPicture {
  std::string mime;  ///< "image/jpeg" or "image/png"
  std::vector<std::uint8_t> bytes;
  int width_px = 0;
  int height_px = 0;
  std::string caption;
  double px_per_m = 0.0;  ///< of a plan; then a bar shows the scale. 0: it has none
};

/// Pictures wider than this are scaled down for the page.
constexpr int kReportPictureWidthPx = 480;

/// As JPEG. A picture that cannot be encoded (empty, absurdly large) comes back without bytes.
ReportPicture PhotoForReport(const vision::ConstImageView& picture, std::string caption,
                             int most_width_px = kReportPictureWidthPx);

/// A distance image in its colours (range_colours.hpp), as PNG. Scaled by taking pixels, never by
/// mixing ranges.
ReportPicture RangesForReport(const vision::RangeImage& ranges, std::string caption,
                              int most_width_px = kReportPictureWidthPx);

/// RGB8 as PNG, as it is.
ReportPicture PngForReport(const vision::ConstImageView& picture, std::string caption);

}  // namespace kawara::mapper
