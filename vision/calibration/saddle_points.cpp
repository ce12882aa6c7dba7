#include "vision/calibration/saddle_points.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kawara::vision {
namespace {

/// Weaker is noise [levels / px^2].
constexpr double kLeastStrength = 0.3;
/// Of the curvatures across and along: edges that cross at less than some 35 deg are no corner.
constexpr double kMostSkew = 10.0;

cv::Mat MatOf(const GreyPicture& picture) {
  // OpenCV wants to be able to write; nobody does.
  return {picture.height_px, picture.width_px, CV_32F, const_cast<float*>(picture.level.data())};
}

SaddlePoint SaddleOf(double uu, double uv, double vv) {
  // Eigenvalues of the Hessian: bright along the positive one.
  const double mean = 0.5 * (uu + vv), half = 0.5 * (uu - vv), root = std::hypot(half, uv);
  const double angle = 0.5 * std::atan2(uv, half);
  SaddlePoint point;
  point.bright = {std::cos(angle), std::sin(angle)};
  const Eigen::Vector2d dark(-point.bright.y(), point.bright.x());
  const double rise = mean + root, fall = root - mean;
  point.edge_a = (std::sqrt(fall) * point.bright + std::sqrt(rise) * dark).normalized();
  point.edge_b = (std::sqrt(fall) * point.bright - std::sqrt(rise) * dark).normalized();
  return point;
}

}  // namespace

float GreyPicture::Sample(double u, double v) const {
  u = std::clamp(u, 0.0, width_px - 1.001);
  v = std::clamp(v, 0.0, height_px - 1.001);
  const int iu = static_cast<int>(u), iv = static_cast<int>(v);
  const auto fu = static_cast<float>(u - iu), fv = static_cast<float>(v - iv);
  return (at(iu, iv) * (1 - fu) + at(iu + 1, iv) * fu) * (1 - fv) +
         (at(iu, iv + 1) * (1 - fu) + at(iu + 1, iv + 1) * fu) * fv;
}

std::vector<SaddlePoint> FindSaddlePoints(const GreyPicture& picture, double blur_px, int limit) {
  std::vector<SaddlePoint> points;
  if (picture.width_px < 8 || picture.height_px < 8) return points;
  cv::Mat smooth, uu, uv, vv;
  cv::GaussianBlur(MatOf(picture), smooth, {}, blur_px, blur_px, cv::BORDER_REPLICATE);
  cv::Sobel(smooth, uu, CV_32F, 2, 0, 3, 0.25);
  cv::Sobel(smooth, vv, CV_32F, 0, 2, 3, 0.25);
  cv::Sobel(smooth, uv, CV_32F, 1, 1, 3, 0.25);
  cv::Mat strength = uv.mul(uv) - uu.mul(vv), highest;
  cv::dilate(strength, highest, cv::Mat::ones(5, 5, CV_8U));
  for (int v = 3; v < strength.rows - 3; ++v) {
    for (int u = 3; u < strength.cols - 3; ++u) {
      const double s = static_cast<double>(strength.at<float>(v, u));
      if (s < kLeastStrength * kLeastStrength || strength.at<float>(v, u) < highest.at<float>(v, u))
        continue;
      const double a = static_cast<double>(uu.at<float>(v, u)),
                   b = static_cast<double>(uv.at<float>(v, u)),
                   c = static_cast<double>(vv.at<float>(v, u));
      const double mean = 0.5 * (a + c), root = std::hypot(0.5 * (a - c), b);
      if (root + std::abs(mean) > kMostSkew * (root - std::abs(mean))) continue;
      SaddlePoint point = SaddleOf(a, b, c);
      // Where the quadratic has its flat place.
      Eigen::Matrix2d hessian;
      hessian << a, b, b, c;
      const Eigen::Vector2d slope(
          0.5 * static_cast<double>(smooth.at<float>(v, u + 1) - smooth.at<float>(v, u - 1)),
          0.5 * static_cast<double>(smooth.at<float>(v + 1, u) - smooth.at<float>(v - 1, u)));
      const Eigen::Vector2d shift = -hessian.inverse() * slope;
      if (!(shift.cwiseAbs().maxCoeff() < 1.5)) continue;
      point.pixel_px = Eigen::Vector2d(u, v) + shift;
      point.strength = std::sqrt(s);
      points.push_back(point);
    }
  }
  std::ranges::stable_sort(points, std::ranges::greater(), &SaddlePoint::strength);
  if (static_cast<int>(points.size()) > limit) points.resize(static_cast<std::size_t>(limit));
  return points;
}

Gradient GradientOf(const GreyPicture& picture) {
  Gradient gradient;
  for (GreyPicture* part : {&gradient.u, &gradient.v}) {
    part->width_px = picture.width_px;
    part->height_px = picture.height_px;
    part->level.resize(picture.level.size());
  }
  cv::Mat u = MatOf(gradient.u), v = MatOf(gradient.v);
  // Scharr's: the same slope in all directions to a per cent.
  cv::Scharr(MatOf(picture), u, CV_32F, 1, 0, 1.0 / 32, 0, cv::BORDER_REPLICATE);
  cv::Scharr(MatOf(picture), v, CV_32F, 0, 1, 1.0 / 32, 0, cv::BORDER_REPLICATE);
  return gradient;
}

std::optional<Eigen::Vector2d> RefineCrossing(const Gradient& gradient,
                                              const Eigen::Vector2d& start_px, double window_px) {
  Eigen::Vector2d at = start_px;
  // The weight has died away there, so that the window's own edges do not pull.
  const int reach = static_cast<int>(std::ceil(1.5 * window_px));
  const double inverse_variance = 4.0 / (window_px * window_px);
  for (int i = 0; i < 30; ++i) {
    if (!(at.x() > reach + 1 && at.y() > reach + 1 && at.x() < gradient.u.width_px - reach - 2 &&
          at.y() < gradient.u.height_px - reach - 2)) {
      return {};
    }
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    const int cu = static_cast<int>(std::lround(at.x())),
              cv = static_cast<int>(std::lround(at.y()));
    for (int v = cv - reach; v <= cv + reach; ++v) {
      for (int u = cu - reach; u <= cu + reach; ++u) {
        const Eigen::Vector2d from = Eigen::Vector2d(u, v) - at;
        const double weight = std::exp(-0.5 * inverse_variance * from.squaredNorm());
        const Eigen::Vector2d g(static_cast<double>(gradient.u.at(u, v)),
                                static_cast<double>(gradient.v.at(u, v)));
        const Eigen::Matrix2d outer = weight * g * g.transpose();
        normal += outer;
        right += outer * from;
      }
    }
    if (!(normal.determinant() > 1e-3 * normal.trace() * normal.trace())) return {};
    const Eigen::Vector2d step = normal.inverse() * right;
    at += step;
    if (!((at - start_px).norm() < window_px)) return {};
    if (step.norm() < 1e-3) return at;
  }
  return at;
}

}  // namespace kawara::vision
