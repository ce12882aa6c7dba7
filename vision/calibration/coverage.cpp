#include "vision/calibration/coverage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/geodesy.hpp"

namespace kawara::vision {
namespace {

/// Between inside and outside of the rim [levels].
constexpr double kLeastContrast = 25.0;
constexpr int kAzimuths = 180;

/// The level that best parts two groups. Source: Otsu, "A threshold selection method from
/// gray-level histograms", 1979.
double Threshold(const std::vector<double>& levels, double& contrast) {
  std::vector<double> sorted = levels;
  std::ranges::sort(sorted);
  const double all = std::accumulate(sorted.begin(), sorted.end(), 0.0);
  double below = 0.0, best = -1.0, threshold = 0.0;
  const auto n = static_cast<double>(sorted.size());
  for (std::size_t i = 0; i + 1 < sorted.size(); ++i) {
    below += sorted[i];
    const auto count = static_cast<double>(i + 1);
    const double apart = (all - below) / (n - count) - below / count;
    const double between = count * (n - count) * apart * apart;
    if (between <= best) continue;
    best = between;
    threshold = 0.5 * (sorted[i] + sorted[i + 1]);
    contrast = apart;
  }
  return threshold;
}

}  // namespace

void BrightestPicture::Add(const ConstImageView& picture) {
  if (level_.empty()) {
    width_px_ = picture.width_px;
    height_px_ = picture.height_px;
    level_.assign(picture.size_bytes() / kRgbBytes, 0);
  }
  if (picture.width_px != width_px_ || picture.height_px != height_px_) return;
  for (std::size_t i = 0; i < level_.size(); ++i) {
    level_[i] = std::max(level_[i], picture.data[i * kRgbBytes + 1]);
  }
}

std::optional<double> BrightestPicture::RimPx(const Eigen::Vector2d& center_px) const {
  // As far as the picture goes all around.
  const double end = std::min({center_px.x(), center_px.y(), width_px_ - 1 - center_px.x(),
                               height_px_ - 1 - center_px.y()});
  std::vector<double> profile;
  std::vector<double> circle(kAzimuths);
  for (int r = 1; r < end; ++r) {
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2.0 * core::kPi * i / kAzimuths;
      const auto u = static_cast<std::size_t>(std::lround(center_px.x() + r * std::cos(azimuth)));
      const auto v = static_cast<std::size_t>(std::lround(center_px.y() + r * std::sin(azimuth)));
      circle[static_cast<std::size_t>(i)] = level_[v * static_cast<std::size_t>(width_px_) + u];
    }
    std::ranges::nth_element(circle, circle.begin() + kAzimuths / 2);
    profile.push_back(circle[kAzimuths / 2]);
  }
  if (profile.size() < 20) return {};
  double contrast = 0.0;
  const double threshold = Threshold(profile, contrast);
  if (contrast < kLeastContrast || profile.back() > threshold) return {};
  std::size_t rim = profile.size();
  while (rim > 0 && profile[rim - 1] <= threshold) --rim;
  return static_cast<double>(rim);
}

double Coverage::RadiusShare() const {
  return rim_px > low_px ? std::min(1.0, (high_px - low_px) / (rim_px - low_px)) : 1.0;
}

double Coverage::CellShare() const {
  const int first = std::clamp(static_cast<int>(kRings * low_px / rim_px), 0, kRings - 1);
  int filled = 0;
  for (int ring = first; ring < kRings; ++ring) {
    for (const int count : corners[static_cast<std::size_t>(ring)]) filled += count > 0 ? 1 : 0;
  }
  return static_cast<double>(filled) / ((kRings - first) * kSectors);
}

std::string Coverage::EmptyHours() const {
  const int first = std::clamp(static_cast<int>(kRings * low_px / rim_px), 0, kRings - 1);
  std::array<bool, kSectors> empty{};
  for (std::size_t sector = 0; sector < kSectors; ++sector) {
    int cells = 0;
    for (std::size_t ring = static_cast<std::size_t>(first); ring < kRings; ++ring) {
      cells += corners[ring][sector] == 0 ? 1 : 0;
    }
    empty[sector] = 2 * cells >= kRings - first;
  }
  // Sector 0 begins at the left, nine o'clock, and they go on clockwise as v is down.
  const auto is_empty = [&](int hour) { return empty[static_cast<std::size_t>((hour + 3) % 12)]; };
  static_assert(kSectors == 12, "a sector an hour");
  if (std::ranges::all_of(empty, [](bool e) { return e; })) return "all around";
  std::string text;
  for (int hour = 0; hour < 12; ++hour) {
    // A run begins where the hour before is not empty.
    if (!is_empty(hour) || is_empty(hour + 11)) continue;
    int end = hour;
    while (is_empty(end % 12)) ++end;
    const auto name = [](int h) { return std::to_string(h % 12 == 0 ? 12 : h % 12); };
    text += (text.empty() ? "" : ", ") + name(hour) + "-" + name(end);
  }
  return text.empty() ? text : text + " o'clock";
}

Coverage CoverageOf(const std::vector<BoardView>& views, const Eigen::Vector2d& center_px,
                    double rim_px) {
  Coverage coverage;
  coverage.rim_px = rim_px;
  coverage.low_px = std::numeric_limits<double>::infinity();
  for (const BoardView& view : views) {
    for (const BoardCorner& corner : view) {
      const Eigen::Vector2d from = corner.pixel_px - center_px;
      const double r = from.norm();
      coverage.low_px = std::min(coverage.low_px, r);
      coverage.high_px = std::max(coverage.high_px, r);
      const double turn = std::atan2(from.y(), from.x()) / (2.0 * core::kPi) + 0.5;
      const int ring =
          std::clamp(static_cast<int>(Coverage::kRings * r / rim_px), 0, Coverage::kRings - 1);
      const int sector =
          std::clamp(static_cast<int>(Coverage::kSectors * turn), 0, Coverage::kSectors - 1);
      ++coverage.corners[static_cast<std::size_t>(ring)][static_cast<std::size_t>(sector)];
    }
  }
  return coverage;
}

}  // namespace kawara::vision
