#include "sim/camera/dark_picture.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "sim/dice.hpp"

namespace kawara::sim {
namespace {

constexpr int kQuality = 88;
constexpr unsigned kBrightest = 4;  ///< of 255: read-out noise

}  // namespace

core::Expected<Picture> DarkPicture(const Picture& instead_of) {
  cv::Mat image(static_cast<int>(instead_of.height), static_cast<int>(instead_of.width), CV_8UC3);
  Dice dice(instead_of.jpeg.size());
  for (int v = 0; v < image.rows; ++v) {
    auto* row = image.ptr<std::uint8_t>(v);
    for (int i = 0; i < 3 * image.cols; ++i)
      row[i] = static_cast<std::uint8_t>(dice.Next() % kBrightest);
  }
  Picture picture;
  picture.width = instead_of.width;
  picture.height = instead_of.height;
  if (!cv::imencode(".jpg", image, picture.jpeg, {cv::IMWRITE_JPEG_QUALITY, kQuality}))
    return core::Fail(core::ErrorCode::kIo, "encode a dark picture: OpenCV's JPEG encoder failed");
  return picture;
}

}  // namespace kawara::sim
