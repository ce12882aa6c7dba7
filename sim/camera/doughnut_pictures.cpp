#include "sim/camera/doughnut_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/geodesy.hpp"
#include "sim/camera/caption.hpp"

namespace kawara::sim {
namespace {

/// A picture prepared for a yaw this near is used as it is: one pixel on the outer circle of 2048
/// pixels, 0.06 deg.
constexpr double kSameYaw_rad = 0.001;
/// Columns repeated at the ends for interpolation across the seam.
constexpr int kMarginPx = 2;
/// OpenCV's remap addresses its source with 16-bit integers.
constexpr int kMaxPanoramaWidthPx = 16000;
constexpr float kOutside = -1000.0F;

}  // namespace

core::Expected<DoughnutPictures> DoughnutPictures::Open(const std::filesystem::path& panorama,
                                                        const vision::DoughnutParameters& geometry,
                                                        int jpeg_quality) {
  const core::Expected<vision::DoughnutCamera> camera = vision::DoughnutCamera::Create(geometry);
  if (!camera) return tl::unexpected(camera.error());
  if (!std::filesystem::is_regular_file(panorama)) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "panorama " + panorama.string() + ": no such file");
  }
  const cv::Mat picture =
      cv::imread(panorama.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (picture.empty()) {
    return core::Fail(core::ErrorCode::kFormat,
                      "panorama " + panorama.string() + ": cannot be read as a picture");
  }
  if (picture.cols != 2 * picture.rows || picture.cols > kMaxPanoramaWidthPx || picture.cols < 64) {
    return core::Fail(core::ErrorCode::kFormat,
                      "panorama " + panorama.string() + ": is " + std::to_string(picture.cols) +
                          " x " + std::to_string(picture.rows) +
                          "; expected a full sphere, 2:1, 64..16000 wide");
  }
  return DoughnutPictures(*camera, picture, jpeg_quality);
}

DoughnutPictures::DoughnutPictures(const vision::DoughnutCamera& camera, const cv::Mat& panorama,
                                   int jpeg_quality)
    : panorama_width_px_(panorama.cols),
      jpeg_quality_(jpeg_quality),
      rendered_yaw_rad_(std::numeric_limits<double>::quiet_NaN()) {
  cv::hconcat(std::vector<cv::Mat>{panorama.colRange(panorama.cols - kMarginPx, panorama.cols),
                                   panorama, panorama, panorama.colRange(0, 2 * kMarginPx)},
              wide_);
  const cv::Size size(camera.width_px(), camera.height_px());
  base_u_.create(size, CV_32FC1);
  map_v_.create(size, CV_32FC1);
  const double columns_per_rad = panorama.cols / (2.0 * core::kPi);
  const double rows_per_rad = panorama.rows / core::kPi;
  const double caption_bottom_rad =
      camera.Elevations().bottom_rad + kCaptionMargin_deg * core::kRadFromDeg;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const auto ray = camera.Unproject({static_cast<double>(u), static_cast<double>(v)});
      if (!ray) {
        base_u_.at<float>(v, u) = map_v_.at<float>(v, u) = kOutside;
        continue;
      }
      // Camera frame: X up, Y right, Z forward.
      const double theta = std::atan2(ray->y(), ray->z());
      const double phi = std::asin(std::clamp(ray->x(), -1.0, 1.0));
      base_u_.at<float>(v, u) =
          static_cast<float>((theta + core::kPi) * columns_per_rad - 0.5 + kMarginPx);
      map_v_.at<float>(v, u) = static_cast<float>((core::kPi / 2.0 - phi) * rows_per_rad - 0.5);
      const double across = theta * core::kDegFromRad / kCaptionWidth_deg + 0.5;
      const double up = (phi - caption_bottom_rad) * core::kDegFromRad / kCaptionHeight_deg;
      if (across >= 0.0 && across < 1.0 && up > 0.0 && up <= 1.0) {
        caption_pixels_.push_back(
            {{u, v}, {static_cast<float>(across), static_cast<float>(1.0 - up)}});
      }
    }
  }
}

void DoughnutPictures::Render(double yaw_rad) {
  // A pixel at theta sees azimuth theta + yaw. Whole columns by choosing the window, the rest by
  // the map.
  double turn = std::fmod(yaw_rad / (2.0 * core::kPi), 1.0);
  if (turn < 0.0) turn += 1.0;
  const double columns = turn * panorama_width_px_;
  const int whole = std::min(static_cast<int>(columns), panorama_width_px_ - 1);
  cv::add(base_u_, cv::Scalar(columns - whole), map_u_);
  const cv::Mat window = wide_.colRange(whole, whole + panorama_width_px_ + 3 * kMarginPx);
  cv::remap(window, image_, map_u_, map_v_, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
            cv::Scalar(0, 0, 0));
  rendered_yaw_rad_ = yaw_rad;
}

void DoughnutPictures::Prepare(double yaw_rad) {
  if (!(std::abs(core::WrapPi(yaw_rad - rendered_yaw_rad_)) < kSameYaw_rad)) Render(yaw_rad);
}

void DoughnutPictures::PutCaption(const Caption& caption) {
  const cv::Mat text = DrawCaption(caption);
  const auto columns = static_cast<float>(text.cols);
  const auto rows = static_cast<float>(text.rows);
  for (const CaptionPixel& pixel : caption_pixels_) {
    const int x = std::min(static_cast<int>(pixel.from.x * columns), text.cols - 1);
    const int y = std::min(static_cast<int>(pixel.from.y * rows), text.rows - 1);
    const std::uint8_t grey = text.at<std::uint8_t>(y, x);
    image_.at<cv::Vec3b>(pixel.at) = cv::Vec3b(grey, grey, grey);
  }
}

core::Expected<Picture> DoughnutPictures::Expose(double yaw_rad, const Caption& caption) {
  if (!(std::abs(core::WrapPi(yaw_rad - rendered_yaw_rad_)) < kSameYaw_rad)) {
    ++rendered_late_;
    Render(yaw_rad);
  }
  PutCaption(caption);
  Picture picture;
  picture.width = static_cast<std::uint32_t>(image_.cols);
  picture.height = static_cast<std::uint32_t>(image_.rows);
  if (!cv::imencode(".jpg", image_, picture.jpeg, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality_})) {
    return core::Fail(core::ErrorCode::kIo, "compress the simulated picture: failed");
  }
  return picture;
}

}  // namespace kawara::sim
