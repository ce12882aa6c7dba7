#include "vision/source_frame.hpp"

#include <algorithm>

namespace kawara::vision {

std::string SizeText(int width_px, int height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px) + " px";
}

core::Expected<ConstImageView> RgbPixels(const SourceFrame& frame) {
  const ConstImageView picture{frame.bytes.data(), frame.width_px, frame.height_px};
  if (picture.empty() || picture.size_bytes() != frame.bytes.size()) {
    return core::Fail(core::ErrorCode::kFormat,
                      "camera frame: " + std::to_string(frame.bytes.size()) + " bytes are not " +
                          SizeText(frame.width_px, frame.height_px) + " of RGB");
  }
  return picture;
}

core::Expected<ConstYuv420View> FramePlanes::Of(const SourceFrame& frame) {
  const bool known = !planes_.empty() && frame.format == known_.format &&
                     frame.width_px == known_.width_px && frame.height_px == known_.height_px &&
                     std::equal(frame.bytes.begin(), frame.bytes.end(), known_bytes_.begin(),
                                known_bytes_.end());  // by memcmp, unlike std::ranges::equal
  if (known) return planes_;
  planes_ = {};
  auto decoded = Decode(frame);
  if (!decoded) return decoded;
  known_ = {frame.format, frame.width_px, frame.height_px, {}};
  known_bytes_.assign(frame.bytes.begin(), frame.bytes.end());
  planes_ = *decoded;
  return planes_;
}

core::Expected<ConstYuv420View> FramePlanes::Decode(const SourceFrame& frame) {
  if (frame.format == SourceFrame::Format::kJpeg) return decoder_.DecodeYuv420(frame.bytes);
  const auto rgb = RgbPixels(frame);
  if (!rgb) return tl::unexpected(rgb.error());
  const Yuv420View planes = converted_.View(rgb->width_px, rgb->height_px);
  Yuv420FromRgb(*rgb, planes);
  return planes;
}

}  // namespace kawara::vision
