#pragma once
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/rtk_colour.hpp"

namespace kawara::gis {

/// Where a text stands about its point.
enum class Anchor { kLeft, kCentre, kRight };

/// A picture to draw on in final pixels; kept three times as large inside and averaged down when
/// saved, which makes lines and lettering smooth. Inside gis/ only.
class MapCanvas {
 public:
  MapCanvas(int width_px, int height_px, Colour paper);

  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Colour colour, double width_px);
  void Disc(const Eigen::Vector2d& centre, double radius_px, Colour fill, Colour rim,
            double rim_px);
  void Polygon(const std::vector<Eigen::Vector2d>& corners, Colour fill);
  void Rectangle(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Colour colour,
                 double width_px);
  void Fill(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Colour colour);
  /// ASCII, the point is on the text's base line; `halo`: a rim of paper colour that keeps it
  /// readable on lines.
  void Text(const Eigen::Vector2d& at, const std::string& text, double height_px, Colour colour,
            Anchor anchor = Anchor::kLeft, bool halo = false, bool bold = false);
  double TextWidth(const std::string& text, double height_px, bool bold = false) const;

  /// PNG through a temporary file. Errors: kIo, kFull, kPermission.
  core::Expected<void> Save(const std::string& path) const;

 private:
  static constexpr int kOversample = 3;
  cv::Mat image_;
  Colour paper_;
};

}  // namespace kawara::gis
