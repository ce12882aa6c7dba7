#include "onboard/mapper/report/report_picture.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "onboard/mapper/report/range_colours.hpp"
#include "vision/jpeg.hpp"
#include "vision/png.hpp"

namespace kawara::mapper {
namespace {

cv::Mat AsMat(const vision::ConstImageView& picture) {
  // OpenCV has no matrix of constants; nothing here writes to it.
  return {picture.height_px, picture.width_px, CV_8UC3, const_cast<std::uint8_t*>(picture.data)};
}

cv::Mat ScaledDown(const cv::Mat& picture, int most_width_px, cv::InterpolationFlags how) {
  if (picture.cols <= most_width_px) return picture;
  const double scale = static_cast<double>(most_width_px) / picture.cols;
  cv::Mat small;
  cv::resize(picture, small, {most_width_px, std::max(1, cvRound(scale * picture.rows))}, 0, 0,
             how);
  return small;
}

ReportPicture AsPng(const cv::Mat& rgb, std::string caption) {
  ReportPicture out{"image/png", {}, rgb.cols, rgb.rows, std::move(caption), 0.0};
  auto png = vision::EncodePng({rgb.data, rgb.cols, rgb.rows}, vision::kPngSmall);
  if (png) out.bytes = std::move(*png);
  return out;
}

}  // namespace

ReportPicture PhotoForReport(const vision::ConstImageView& picture, std::string caption,
                             int most_width_px) {
  ReportPicture out{"image/jpeg", {}, 0, 0, std::move(caption), 0.0};
  if (picture.empty()) return out;
  const cv::Mat small = ScaledDown(AsMat(picture), most_width_px, cv::INTER_AREA);
  vision::JpegEncoder encoder;
  const auto jpeg = encoder.Encode({small.data, small.cols, small.rows}, {});
  if (!jpeg) return out;
  out.bytes.assign(jpeg->begin(), jpeg->end());
  out.width_px = small.cols;
  out.height_px = small.rows;
  return out;
}

ReportPicture RangesForReport(const vision::RangeImage& ranges, std::string caption,
                              int most_width_px) {
  if (ranges.range_m.empty()) return {"image/png", {}, 0, 0, std::move(caption), 0.0};
  const std::vector<std::uint8_t> rgb = RangeColours(ranges);
  const cv::Mat whole = AsMat({rgb.data(), ranges.width_px, ranges.height_px});
  return AsPng(ScaledDown(whole, most_width_px, cv::INTER_NEAREST), std::move(caption));
}

ReportPicture PngForReport(const vision::ConstImageView& picture, std::string caption) {
  if (picture.empty()) return {"image/png", {}, 0, 0, std::move(caption), 0.0};
  return AsPng(AsMat(picture), std::move(caption));
}

}  // namespace kawara::mapper
