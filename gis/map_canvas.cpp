#include "gis/map_canvas.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace kawara::gis {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
/// Height of a capital of that font at scale 1 [px].
constexpr double kCapitalPx = 21.0;
/// OpenCV takes coordinates with this many fractional bits.
constexpr int kShift = 4;

cv::Scalar Bgr(Colour c) {
  return {static_cast<double>(c.blue), static_cast<double>(c.green), static_cast<double>(c.red)};
}

cv::Point Fixed(Eigen::Vector2d p, double scale) {
  constexpr double kOne = 1 << kShift;
  return {static_cast<int>(std::lround(p.x() * scale * kOne)),
          static_cast<int>(std::lround(p.y() * scale * kOne))};
}

int Thickness(double width_px, double scale) {
  return std::max(1, static_cast<int>(std::lround(width_px * scale)));
}

}  // namespace

MapCanvas::MapCanvas(int width_px, int height_px, Colour paper)
    : image_(height_px * kOversample, width_px * kOversample, CV_8UC3, Bgr(paper)), paper_(paper) {}

void MapCanvas::Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Colour colour,
                     double width_px) {
  cv::line(image_, Fixed(a, kOversample), Fixed(b, kOversample), Bgr(colour),
           Thickness(width_px, kOversample), cv::LINE_AA, kShift);
}

void MapCanvas::Disc(const Eigen::Vector2d& centre, double radius_px, Colour fill, Colour rim,
                     double rim_px) {
  constexpr double kOne = 1 << kShift;
  const int radius = static_cast<int>(std::lround(radius_px * kOversample * kOne));
  const cv::Point at = Fixed(centre, kOversample);
  cv::circle(image_, at, radius, Bgr(fill), cv::FILLED, cv::LINE_AA, kShift);
  cv::circle(image_, at, radius, Bgr(rim), Thickness(rim_px, kOversample), cv::LINE_AA, kShift);
}

void MapCanvas::Polygon(const std::vector<Eigen::Vector2d>& corners, Colour fill) {
  std::vector<cv::Point> points;
  points.reserve(corners.size());
  for (const auto& corner : corners) points.push_back(Fixed(corner, kOversample));
  cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{points}, Bgr(fill), cv::LINE_AA, kShift);
}

void MapCanvas::Rectangle(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Colour colour,
                          double width_px) {
  cv::rectangle(image_, Fixed(from, kOversample), Fixed(to, kOversample), Bgr(colour),
                Thickness(width_px, kOversample), cv::LINE_AA, kShift);
}

void MapCanvas::Fill(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Colour colour) {
  cv::rectangle(image_, Fixed(from, kOversample), Fixed(to, kOversample), Bgr(colour), cv::FILLED,
                cv::LINE_8, kShift);
}

double MapCanvas::TextWidth(const std::string& text, double height_px, bool bold) const {
  const double scale = height_px * kOversample / kCapitalPx;
  const int thickness = Thickness(height_px / (bold ? 6.0 : 10.0), kOversample);
  return cv::getTextSize(text, kFont, scale, thickness, nullptr).width /
         static_cast<double>(kOversample);
}

void MapCanvas::Text(const Eigen::Vector2d& at, const std::string& text, double height_px,
                     Colour colour, Anchor anchor, bool halo, bool bold) {
  const double width = TextWidth(text, height_px, bold);
  double left = at.x();
  if (anchor == Anchor::kCentre) left -= width / 2.0;
  if (anchor == Anchor::kRight) left -= width;
  const cv::Point origin(static_cast<int>(std::lround(left * kOversample)),
                         static_cast<int>(std::lround(at.y() * kOversample)));
  const double scale = height_px * kOversample / kCapitalPx;
  const int thickness = Thickness(height_px / (bold ? 6.0 : 10.0), kOversample);
  if (halo)
    cv::putText(image_, text, origin, kFont, scale, Bgr(paper_), thickness + 4 * kOversample,
                cv::LINE_AA);
  cv::putText(image_, text, origin, kFont, scale, Bgr(colour), thickness, cv::LINE_AA);
}

core::Expected<void> MapCanvas::Save(const std::string& path) const {
  cv::Mat small;
  cv::resize(image_, small, {}, 1.0 / kOversample, 1.0 / kOversample, cv::INTER_AREA);
  std::vector<unsigned char> png;
  if (!cv::imencode(".png", small, png))
    return core::Fail(core::ErrorCode::kIo, path + ": the PNG encoder failed");
  const std::string temporary = path + ".tmp";
  std::FILE* file = std::fopen(temporary.c_str(), "wbe");
  if (file == nullptr) return tl::unexpected(core::ErrnoError("create " + path, errno));
  const bool written = std::fwrite(png.data(), 1, png.size(), file) == png.size();
  const int write_errno = errno;
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed || std::rename(temporary.c_str(), path.c_str()) != 0) {
    const core::Error error = core::ErrnoError("write " + path, written ? errno : write_errno);
    std::remove(temporary.c_str());
    return tl::unexpected(error);
  }
  return {};
}

}  // namespace kawara::gis
