#include "vision/stereo/paper_matcher.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

/// A parabola that is bent by so many standard deviations of the bend is a minimum.
constexpr double kSureBend = 3.0;
/// What remains in the best textured places: steps of a pixel, windows that do not fit a slanted
/// surface [px].
constexpr double kFloorSd = 0.1;

/// Whether turning from a ray's "up" towards its "right" is clockwise in the picture or not: the
/// sign of a small square's area.
float Handedness(const MaskedRays& rays) {
  const auto width = static_cast<std::size_t>(rays.width_px());
  double total = 0.0;
  constexpr int kEvery = 8;
  for (int v = 0; v + 1 < rays.height_px(); v += kEvery) {
    for (int u = 0; u + 1 < rays.width_px(); u += kEvery) {
      const std::size_t i = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
      if (!rays.seen(i) || !rays.seen(i + 1) || !rays.seen(i + width)) continue;
      const auto ray = [&](std::size_t k) {
        return Eigen::Vector3f(rays.x()[k], rays.y()[k], rays.z()[k]);
      };
      const Eigen::Vector3f right = ray(i + 1) - ray(i), down = ray(i + width) - ray(i);
      total += static_cast<double>(right.cross(down).dot(ray(i)));
    }
  }
  return total < 0.0 ? -1.0F : 1.0F;
}

/// Half of the square about a pixel that a window needs, turned in any way, with its centre up to a
/// pixel right and down; its bilinear taps included.
int Margin(float pitch_px) {
  const double corner_px = std::sqrt(2.0) * paper::kHalfWindow * static_cast<double>(pitch_px);
  return static_cast<int>(1.01 + corner_px) + 1;
}

paper::WindowPlace Place(float u_px, float v_px, float up_u, float up_v, float across,
                         float pitch_px) {
  const float square = up_u * up_u + up_v * up_v;
  const float scale = square > 0.0F ? pitch_px / std::sqrt(square) : 0.0F;
  const float u = square > 0.0F ? up_u * scale : pitch_px, v = up_v * scale;
  return {u_px, v_px, u, v, -across * v, across * u};
}

}  // namespace

void PaperMatcher::Prepare(const StereoView& view, int margin_px, Prepared& out) {
  view.camera->rays().Pack(view.picture, out.packed);
  out.width_px = view.picture.width_px;
  out.height_px = view.picture.height_px;
  const auto width = static_cast<std::size_t>(out.width_px);
  const auto height = static_cast<std::size_t>(out.height_px);
  // A cache line more than the picture, as its width is often a power of two.
  constexpr std::size_t kPad = 4;
  const std::size_t stride = width + kPad;
  out.squares.resize(2 * stride * height);
  for (std::size_t v = 0; v < height; ++v) {
    const std::uint32_t* row = out.packed.data() + v * width;
    // Nothing is looked up in the last row.
    paper::SquareRow(row, v + 1 < height ? row + width : row, width,
                     out.squares.data() + 2 * v * stride);
  }
  out.picture = {out.squares.data(), static_cast<int>(stride)};
  FindRoom(margin_px, out);
  FindEdges(out);
}

void PaperMatcher::FindRoom(int margin_px, Prepared& out) {
  const auto width = static_cast<std::size_t>(out.width_px);
  const auto height = static_cast<std::size_t>(out.height_px);
  const auto margin = static_cast<std::size_t>(margin_px);
  out.gate.assign(width * height, 0);
  seen_rows_.assign(width, 0);
  for (std::size_t v = 0; v < height; ++v) {
    const std::uint32_t* row = out.packed.data() + v * width;
    std::size_t seen = 0;
    for (std::size_t u = 0; u < width; ++u) {
      seen = row[u] != 0 ? seen + 1 : 0;
      if (u < margin) continue;
      std::uint16_t& rows = seen_rows_[u - margin];
      rows = static_cast<std::uint16_t>(
          seen > 2 * margin ? std::min<std::size_t>(rows + 1U, 2 * margin + 1) : 0);
    }
    if (v < margin) continue;
    std::uint8_t* gate = out.gate.data() + (v - margin) * width;
    for (std::size_t u = 0; u < width; ++u) gate[u] = seen_rows_[u] > 2 * margin ? kRoom : 0;
  }
}

void PaperMatcher::FindEdges(Prepared& out) {
  const auto width = static_cast<std::size_t>(out.width_px);
  magnitude_.resize(width);
  for (int v = 1; v + 1 < out.height_px; ++v) {
    const std::size_t first = static_cast<std::size_t>(v) * width;
    const std::uint32_t* row = out.packed.data() + first;
    paper::SobelRow(row - width, row, row + width, width, magnitude_.data());
    std::uint8_t* gate = out.gate.data() + first;
    for (std::size_t u = 1; u + 1 < width; ++u) {
      gate[u] =
          static_cast<std::uint8_t>(gate[u] | (magnitude_[u] >= options_.least_edge ? kEdge : 0));
    }
  }
  for (std::size_t v = 0; v + 1 < static_cast<std::size_t>(out.height_px); ++v) {
    std::uint8_t* gate = out.gate.data() + v * width;
    const std::uint8_t* below = gate + width;
    static_assert(kNearEdge == 2 * kEdge);
    for (std::size_t u = 0; u + 1 < width; ++u) {
      gate[u] = static_cast<std::uint8_t>(
          gate[u] | ((gate[u] | gate[u + 1] | below[u] | below[u + 1]) & kEdge) << 1);
    }
  }
}

core::Expected<void> PaperMatcher::Match(const StereoView& a, const StereoView& b,
                                         RangeImage& ranges, const StepDoubt& doubt) {
  const auto pair = EpipolarPair::FromPoses(a.map_from_camera, b.map_from_camera);
  if (!pair) return tl::unexpected(pair.error());
  across_a_ = across_b_ = pitch_b_ = 1.0F;
  if (a.camera != b.camera) {
    across_a_ = Handedness(a.camera->rays());
    across_b_ = Handedness(b.camera->rays());
    pitch_b_ = static_cast<float>(b.camera->mean_px_per_rad() / a.camera->mean_px_per_rad());
  }
  Prepare(a, Margin(1.0F), a_);
  Prepare(b, Margin(pitch_b_), b_);
  EpipolarCurve curve(*b.camera, *pair, options_.nearest_m);
  const ArcProjector at_a(*a.camera, Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX());
  const MaskedRays& rays = a.camera->rays();
  ranges.Reset(a_.width_px, a_.height_px);
  constexpr float kOne[16] = {1.0F}, kNone[16] = {};
  float u[16], v[16], up_u[16], up_v[16];
  paper::WindowLevels window;
  for (int row = 0; row < a_.height_px; ++row) {
    for (int column = 0; column < a_.width_px; ++column) {
      const std::size_t i = ranges.index(column, row);
      if (!candidate(i)) continue;
      const Eigen::Vector3f ray(rays.x()[i], rays.y()[i], rays.z()[i]);
      const std::span<const CurveStep> steps = curve.Follow(ray);
      at_a.Project(ray, Eigen::Vector3f::Zero(), kOne, kNone, 1, {u, v, up_u, up_v});
      paper::SampleWindow(a_.picture,
                          Place(static_cast<float>(column), static_cast<float>(row), up_u[0],
                                up_v[0], across_a_, 1.0F),
                          window);
      const Depth depth = MatchPixel(window, steps, curve.alpha_rad(), *pair, doubt);
      ranges.range_m[i] = depth.range_m;
      ranges.sd_m[i] = depth.sd_m;
    }
  }
  return {};
}

PaperMatcher::Depth PaperMatcher::MatchPixel(const paper::WindowLevels& window,
                                             std::span<const CurveStep> steps, double alpha_rad,
                                             const EpipolarPair& pair, const StepDoubt& doubt) {
  constexpr Depth kUnknown{RangeImage::kUnknown, RangeImage::kUnknown};
  const auto place_of = [this](const CurveStep& step) {
    return Place(step.u_px, step.v_px, step.up_u, step.up_v, across_b_, pitch_b_);
  };
  // Without branches: whether a step is wanted is hard to foretell.
  place_steps_.resize(steps.size());
  std::size_t count = 0;
  for (std::size_t s = 0; s < steps.size(); ++s) {
    constexpr std::uint8_t kWanted = kRoom | kNearEdge;
    place_steps_[count] = s;
    count += (b_.at(steps[s].u_px, steps[s].v_px) & kWanted) == kWanted ? 1U : 0U;
  }
  if (count == 0) return kUnknown;
  places_.resize(count);
  for (std::size_t i = 0; i < count; ++i) places_[i] = place_of(steps[place_steps_[i]]);
  first_groups_.resize(places_.size());
  const paper::Found found =
      paper::Search(window, b_.picture, places_.data(), places_.size(), first_groups_.data());
  const std::size_t step = place_steps_[found.place];
  if (step == 0 || step + 1 >= steps.size()) return kUnknown;
  const CurveStep &before = steps[step - 1], &at = steps[step], &after = steps[step + 1];
  for (const CurveStep* neighbour : {&before, &after}) {
    if (neighbour->gap() || (b_.at(neighbour->u_px, neighbour->v_px) & kRoom) == 0) return kUnknown;
  }
  const auto cost = [&](const CurveStep& place) {
    return static_cast<double>(paper::Cost(window, b_.picture, place_of(place))) / paper::kCostUnit;
  };
  const double least = static_cast<double>(found.cost) / paper::kCostUnit;
  const double left = cost(before), right = cost(after);
  const double curvature = left - 2.0 * least + right;
  const double offset_px =
      curvature > 0.0 ? std::clamp(0.5 * (left - right) / curvature, -1.0, 1.0) : 0.0;
  // With residuals of variance n^2 and slopes g of the levels along the curve the sum is about
  // sum k (n^2 + g^2 x^2): its curvature is 2 sum k g^2, and the vertex has the variance
  // n^2 sum k^2 g^2 / (sum k g^2)^2. The squares of the residuals alone bend the three sums by
  // n^2 sqrt(12 sum k^2), one standard deviation: an edge along the curve, say a line on the road
  // that the robot follows, has no more than that and could be anywhere.
  const double noise = least / paper::TotalWeight();
  const double share = paper::TotalSquaredWeight() / paper::TotalWeight();
  const double bend_sd = noise * std::sqrt(12.0 * paper::TotalSquaredWeight());
  double variance_px2 = static_cast<double>(steps.size() * steps.size()) / 12.0;
  if (curvature > kSureBend * bend_sd) {
    variance_px2 =
        std::min(variance_px2, 2.0 * share * noise / (curvature - bend_sd) + kFloorSd * kFloorSd);
  }
  const double rad_per_px = 0.5 * static_cast<double>(after.delta_rad - before.delta_rad);
  const double delta_rad = static_cast<double>(at.delta_rad) + offset_px * rad_per_px;
  if (!(delta_rad > 0.0)) return kUnknown;
  const double range_m = pair.Range(alpha_rad, delta_rad);
  const double sine = std::sin(delta_rad);
  const double metres_per_rad = pair.baseline_m * std::sin(alpha_rad) / (sine * sine);
  const double by_match_m = metres_per_rad * rad_per_px * std::sqrt(variance_px2);
  const double by_turn_m = metres_per_rad * doubt.turn_sd_rad;
  const double by_length_m = range_m * doubt.length_relative_sd;
  return {static_cast<float>(range_m),
          static_cast<float>(std::sqrt(by_match_m * by_match_m + by_turn_m * by_turn_m +
                                       by_length_m * by_length_m))};
}

}  // namespace kawara::vision
