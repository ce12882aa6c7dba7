#include "vision/refine/corner_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "vision/refine/patch_align.hpp"
#include "vision/stereo/rectifier.hpp"

namespace kawara::vision {
namespace {

/// Of the tracking sphere, in parts of the camera's mean resolution.
constexpr double kGridDensity = 0.9;
constexpr double kPoleCap = 12.0 * core::kRadFromDeg;
constexpr int kWindow = 15;  ///< of Lucas and Kanade [px]
constexpr int kLevels = 3;   ///< above the full size
/// Before patches are aligned: their gradients are then those of a smooth surface [px].
constexpr double kSmooth_px = 0.8;
/// Forth and back a corner must come home within this [px].
constexpr float kHome = 0.1F;
/// No corner is nearer to where the camera sees nothing [px].
constexpr int kMargin = PatchAlignOptions{}.half_px + 2;
/// Corners are looked for at half size; this block's gradients make one.
constexpr int kCornerBlock = 5;

struct GreyPicture {
  cv::Mat grey;
  cv::Mat inside;  ///< 255 where a window sees the camera's picture only
  std::vector<cv::Mat> pyramid;
  cv::Mat smooth;  ///< what patches are aligned on
};

/// Green counts most, as it does in the eye and in the sensor's mosaic.
std::uint8_t Grey(std::uint32_t rgbx) {
  return static_cast<std::uint8_t>(
      ((rgbx & 0xFF) + 2 * ((rgbx >> 8) & 0xFF) + ((rgbx >> 16) & 0xFF)) >> 2);
}

void ToGrey(const RectifiedPicture& picture, GreyPicture& out) {
  const int width = picture.grid.width_px, height = picture.grid.height_px;
  out.grey.create(height, width, CV_8U);
  out.inside.create(height, width, CV_8U);
  for (int y = 0; y < height; ++y) {
    const std::uint32_t* from = picture.row(y);
    auto* grey = out.grey.ptr<std::uint8_t>(y);
    auto* inside = out.inside.ptr<std::uint8_t>(y);
    for (int x = 0; x < width; ++x) {
      grey[x] = Grey(from[x]);
      inside[x] = Seen(from[x]) ? 255 : 0;
    }
  }
  const cv::Size margin(2 * kMargin + 1, 2 * kMargin + 1);
  cv::erode(out.inside, out.inside, cv::getStructuringElement(cv::MORPH_RECT, margin),
            cv::Point(-1, -1), 1, cv::BORDER_CONSTANT, cv::Scalar(0));
}

/// Made as bright as the other on the whole: Lucas and Kanade take a patch to be as bright in both.
void MatchBrightness(const GreyPicture& from, GreyPicture& to) {
  cv::Mat both;
  cv::bitwise_and(from.inside, to.inside, both);
  const double wanted = cv::mean(from.grey, both)[0], is = cv::mean(to.grey, both)[0];
  if (is > 1.0 && wanted > 1.0) to.grey.convertTo(to.grey, CV_8U, wanted / is);
}

void MakeLevels(GreyPicture& picture) {
  picture.grey.convertTo(picture.smooth, CV_32F);
  cv::GaussianBlur(picture.smooth, picture.smooth, cv::Size(), kSmooth_px);
  cv::buildOpticalFlowPyramid(picture.grey, picture.pyramid, cv::Size(kWindow, kWindow), kLevels);
}

bool Inside(const GreyPicture& picture, const cv::Point2f& at) {
  const int x = cvRound(at.x), y = cvRound(at.y);
  return x >= 0 && y >= 0 && x < picture.inside.cols && y < picture.inside.rows &&
         picture.inside.at<std::uint8_t>(y, x) != 0;
}

cv::Point2f OnGrid(const EpipolarGrid& grid, const Eigen::Vector3d& ray_epipolar) {
  const double alpha = std::acos(std::clamp(ray_epipolar.x(), -1.0, 1.0));
  double beta = std::atan2(ray_epipolar.z(), ray_epipolar.y());
  if (beta < 0.0) beta += 2.0 * core::kPi;
  return {static_cast<float>(grid.x_px(alpha)), static_cast<float>(grid.y_px(beta))};
}

Eigen::Vector3d RayOf(const EpipolarGrid& grid, const cv::Point2f& at) {
  return EpipolarPair::Ray(grid.alpha_rad(static_cast<double>(at.x)),
                           (static_cast<double>(at.y) + 0.5) / grid.px_per_rad);
}

LevelsView ViewOf(const cv::Mat& levels) {
  return {levels.ptr<float>(), levels.cols, levels.rows,
          static_cast<std::ptrdiff_t>(levels.step1())};
}
Eigen::Vector2f ToEigen(const cv::Point2f& at) { return {at.x, at.y}; }

}  // namespace

class CornerTracker::Implementation {
 public:
  explicit Implementation(const CornerTrackerOptions& options) : options_(options) {}

  core::Expected<std::vector<TrackedCorner>> Track(const StereoView& a, const StereoView& b,
                                                   const std::vector<Eigen::Vector3d>& known) {
    const auto pair = EpipolarPair::FromPoses(a.map_from_camera, b.map_from_camera);
    if (!pair) return tl::unexpected(pair.error());
    const double px_per_rad = options_.px_per_rad > 0.0
                                  ? options_.px_per_rad
                                  : kGridDensity * a.camera->mean_px_per_rad();
    grid_ = EpipolarGrid::Make(px_per_rad, kPoleCap);
    rectifier_.Rectify(*a.camera, a.picture, pair->a_from_epipolar, grid_, rectified_);
    ToGrey(rectified_, a_);
    rectifier_.Rectify(*b.camera, b.picture, pair->b_from_epipolar, grid_, rectified_);
    ToGrey(rectified_, b_);
    MatchBrightness(a_, b_);
    MakeLevels(a_);
    MakeLevels(b_);

    places_a_.clear();
    from_.clear();
    for (std::size_t i = 0; i < known.size(); ++i) {
      const cv::Point2f at = OnGrid(grid_, pair->a_from_epipolar.transpose() * known[i]);
      if (!Inside(a_, at)) continue;
      places_a_.push_back(at);
      from_.push_back(static_cast<std::ptrdiff_t>(i));
    }
    Detect();
    Follow();

    std::vector<TrackedCorner> tracked;
    for (std::size_t i = 0; i < places_a_.size(); ++i) {
      if (forth_[i] == 0 || back_[i] == 0 || !Inside(b_, places_b_[i])) continue;
      const cv::Point2f off = home_[i] - places_a_[i];
      if (off.x * off.x + off.y * off.y > kHome * kHome) continue;
      TrackedCorner corner;
      corner.known = from_[i];
      corner.ray_a = from_[i] >= 0 ? known[static_cast<std::size_t>(from_[i])]
                                   : pair->a_from_epipolar * RayOf(grid_, places_a_[i]);
      corner.ray_b = pair->b_from_epipolar * RayOf(grid_, places_b_[i]);
      tracked.push_back(corner);
    }
    return tracked;
  }

  double px_per_rad() const { return grid_.px_per_rad; }

 private:
  /// New corners: the best of every cell that has none, as many as are wanted.
  void Detect() {
    const int free = options_.wanted - static_cast<int>(places_a_.size());
    if (free <= 0) return;
    cv::pyrDown(a_.grey, half_);
    cv::cornerMinEigenVal(half_, strength_, kCornerBlock, 3);
    // OpenCV scales so that the value is the mean square of the gradient in levels / 255 a pixel.
    const double contrast = options_.least_contrast / 255.0;
    const auto least = static_cast<float>(contrast * contrast);
    const double cells = 1.3 * static_cast<double>(options_.wanted);
    const int side =
        std::max(6, static_cast<int>(std::sqrt(static_cast<double>(half_.total()) / cells)));
    const int columns = (half_.cols + side - 1) / side, rows = (half_.rows + side - 1) / side;
    const auto cell = [&](int x, int y) {
      return static_cast<std::size_t>(y / side) * static_cast<std::size_t>(columns) +
             static_cast<std::size_t>(x / side);
    };
    best_.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows),
                 {0.0F, cv::Point2f()});
    for (const cv::Point2f& at : places_a_) {
      best_[cell(static_cast<int>(at.x / 2), static_cast<int>(at.y / 2))].first = -1.0F;  // taken
    }
    for (int y = 0; y < half_.rows; ++y) {
      const auto* strength = strength_.ptr<float>(y);
      for (int x = 0; x < half_.cols; ++x) {
        auto& [best, place] = best_[cell(x, y)];
        if (best < 0.0F || strength[x] <= best || strength[x] < least) continue;
        const cv::Point2f at(2.0F * static_cast<float>(x), 2.0F * static_cast<float>(y));
        if (!Inside(a_, at)) continue;
        best = strength[x];
        place = at;
      }
    }
    std::erase_if(best_, [](const auto& corner) { return corner.first <= 0.0F; });
    std::stable_sort(best_.begin(), best_.end(),
                     [](const auto& one, const auto& other) { return one.first > other.first; });
    const std::size_t count = std::min(best_.size(), static_cast<std::size_t>(free));
    for (std::size_t i = 0; i < count; ++i) {
      places_a_.push_back(best_[i].second);
      from_.push_back(-1);
    }
  }

  void Follow() {
    forth_.clear();
    back_.clear();
    if (places_a_.empty()) return;
    const cv::Size window(kWindow, kWindow);
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
    cv::calcOpticalFlowPyrLK(a_.pyramid, b_.pyramid, places_a_, places_b_, forth_, error_, window,
                             kLevels, until);
    Align();
  }

  /// From there to where the slanted patch lies, and back.
  void Align() {
    home_ = places_a_;
    back_.assign(places_a_.size(), 0);
    const LevelsView a = ViewOf(a_.smooth), b = ViewOf(b_.smooth);
    for (std::size_t i = 0; i < places_a_.size(); ++i) {
      if (forth_[i] == 0) continue;
      const Eigen::Vector2f from = ToEigen(places_a_[i]);
      const auto there = AlignPatch(a, b, from, ToEigen(places_b_[i]));
      if (!there) continue;
      const auto home = AlignPatch(b, a, *there, from);
      if (!home) continue;
      places_b_[i] = {there->x(), there->y()};
      home_[i] = {home->x(), home->y()};
      back_[i] = 1;
    }
  }

  CornerTrackerOptions options_;
  EpipolarGrid grid_;
  Rectifier rectifier_;
  RectifiedPicture rectified_;
  GreyPicture a_, b_;
  cv::Mat half_, strength_;
  std::vector<std::pair<float, cv::Point2f>> best_;
  std::vector<cv::Point2f> places_a_, places_b_, home_;
  std::vector<std::ptrdiff_t> from_;
  std::vector<std::uint8_t> forth_, back_;
  std::vector<float> error_;
};

CornerTracker::CornerTracker(const CornerTrackerOptions& options)
    : implementation_(std::make_unique<Implementation>(options)) {}
CornerTracker::~CornerTracker() = default;
CornerTracker::CornerTracker(CornerTracker&&) noexcept = default;
CornerTracker& CornerTracker::operator=(CornerTracker&&) noexcept = default;

core::Expected<std::vector<TrackedCorner>> CornerTracker::Track(
    const StereoView& a, const StereoView& b, const std::vector<Eigen::Vector3d>& known_rays) {
  return implementation_->Track(a, b, known_rays);
}

double CornerTracker::px_per_rad() const { return implementation_->px_per_rad(); }

}  // namespace kawara::vision
