#include "vision/calibration/first_guess.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/calibration/board_pose.hpp"

namespace kawara::vision {
namespace {

constexpr CalibrationModel kBending = CalibrationModel::kDoughnutCorrected;
/// Views that are looked at: the rest comes in later.
constexpr std::size_t kViews = 12;
/// Starts that are adjusted.
constexpr std::size_t kStarts = 6;
/// A view that is no better than this is as good as none [px].
constexpr double kWorstPx = 30.0;
/// Offsets of the centre, in parts of the smaller side.
constexpr double kOffsets[] = {-0.12, -0.06, 0.0, 0.06, 0.12};
/// Angles of the centre itself [rad]: of a mirror's ring the inner circle is not at zero.
constexpr double kOffsetAngles[] = {-0.3, 0.0, 0.3, 0.6, 0.9};
/// Pixels per radian, in parts of half the smaller side.
constexpr double kLeastScale = 0.25, kMostScale = 4.0;
constexpr int kScales = 18;

struct Start {
  double score = std::numeric_limits<double>::infinity();
  Eigen::VectorXd parameters;
};

std::optional<Eigen::Isometry3d> PoseOf(const TrialCamera& camera, double square_m,
                                        const BoardView& view, const Eigen::VectorXd& p,
                                        std::vector<Eigen::Vector3d>& rays) {
  std::vector<Eigen::Vector2d> on_board;
  rays.clear();
  const Eigen::Matrix2d inverse = camera.affine().inverse();
  for (const BoardCorner& corner : view) {
    const Eigen::Vector2d plane = inverse * (corner.pixel_px - camera.center_px());
    const double radius = plane.norm();
    // Linear: k1..k3 are still zero.
    const double angle = core::kPi / 2 + (radius - p[3]) / p[4];
    if (!(angle > 0.0 && angle < 0.97 * core::kPi)) return {};
    const Eigen::Vector2d across = std::sin(angle) / std::max(1e-9, radius) * plane;
    rays.emplace_back(across.x(), across.y(), std::cos(angle));
    on_board.push_back(corner.OnBoard(square_m));
  }
  return PoseFromRays(on_board, rays);
}

/// Median distance of a view's corners from a flat board [px].
double Flatness(const TrialCamera& camera, double square_m, const BoardView& view,
                const Eigen::VectorXd& p) {
  std::vector<Eigen::Vector3d> rays;
  const auto pose = PoseOf(camera, square_m, view, p, rays);
  if (!pose) return kWorstPx;
  std::vector<double> errors;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Eigen::Vector2d q = view[i].OnBoard(square_m);
    const Eigen::Vector3d point = *pose * Eigen::Vector3d(q.x(), q.y(), 0.0);
    errors.push_back(rays[i].cross(point.normalized()).norm() * p[4]);
    if (rays[i].dot(point) < 0.0) errors.back() = kWorstPx;
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::ranges::nth_element(errors, middle);
  return std::min(kWorstPx, *middle);
}

/// The best centre for every scale and offset angle, best first.
std::vector<Start> Search(const CalibrationPicture& picture, double square_m,
                          const std::vector<BoardView>& views) {
  std::vector<Start> starts;
  const double side = std::min(picture.width_px, picture.height_px);
  for (int s = 0; s < kScales; ++s) {
    const double scale =
        0.5 * side * kLeastScale * std::pow(kMostScale / kLeastScale, s / (kScales - 1.0));
    for (const double offset_angle : kOffsetAngles) {
      Start best;
      for (const double du : kOffsets) {
        for (const double dv : kOffsets) {
          Eigen::VectorXd p = Eigen::VectorXd::Zero(8);
          p[0] = 0.5 * (picture.width_px - 1) + du * side;
          p[1] = 0.5 * (picture.height_px - 1) + dv * side;
          p[2] = 1.0;
          p[3] = scale * (core::kPi / 2 - offset_angle);
          p[4] = scale;
          const TrialCamera camera(kBending, picture, p);
          double score = 0.0;
          for (const BoardView& view : views) score += Flatness(camera, square_m, view, p);
          if (score < best.score) best = {score, p};
        }
      }
      starts.push_back(best);
    }
  }
  std::ranges::stable_sort(starts, std::ranges::less(), &Start::score);
  return starts;
}

double MedianResidual(const BundleFit& fit) {
  std::vector<double> errors;
  for (const auto& view : fit.residuals) {
    for (const auto& residual : view) errors.push_back(residual.norm());
  }
  if (errors.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::ranges::nth_element(errors, middle);
  return std::isfinite(*middle) ? *middle : std::numeric_limits<double>::infinity();
}

/// Poses of all views for a camera whose radii are linear.
std::optional<BundleState> Posed(const CalibrationPicture& picture, double square_m,
                                 const std::vector<BoardView>& views, const Eigen::VectorXd& p) {
  const TrialCamera camera(kBending, picture, p);
  BundleState state;
  state.parameters = p;
  std::vector<Eigen::Vector3d> rays;
  for (const BoardView& view : views) {
    const auto pose = PoseOf(camera, square_m, view, p, rays);
    if (!pose) return {};
    state.optical_from_board.push_back(*pose);
  }
  return state;
}

}  // namespace

AngleRange SeenAngles(const BundleProblem& problem, const BundleState& state) {
  AngleRange seen{core::kPi, 0.0};
  for (std::size_t v = 0; v < problem.views->size(); ++v) {
    for (const BoardCorner& corner : (*problem.views)[v]) {
      const Eigen::Vector2d q = corner.OnBoard(problem.square_m);
      const Eigen::Vector3d point =
          state.optical_from_board[v] * Eigen::Vector3d(q.x(), q.y(), 0.0);
      const double angle = std::atan2(point.head<2>().norm(), point.z());
      seen.low_rad = std::min(seen.low_rad, angle);
      seen.high_rad = std::max(seen.high_rad, angle);
    }
  }
  return seen;
}

std::optional<BundleState> GuessCamera(const CalibrationPicture& picture, double square_m,
                                       const std::vector<BoardView>& views) {
  std::vector<BoardView> some;
  for (std::size_t i = 0; i < std::min(kViews, views.size()); ++i) {
    some.push_back(views[i * views.size() / std::min(kViews, views.size())]);
  }
  const std::vector<Start> starts = Search(picture, square_m, some);
  std::optional<BundleState> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(kStarts, starts.size()); ++i) {
    if (!std::isfinite(starts[i].score)) break;
    const auto posed = Posed(picture, square_m, views, starts[i].parameters);
    if (!posed) continue;
    BundleProblem problem{kBending, picture, square_m, &views, {}};
    // First the scale and the centre, then how it bends.
    problem.fixed = {false, false, true, false, false, true, true, true};
    BundleFit fit = FitBundle(problem, *posed);
    problem.fixed = {false, false, false, false, false, false, false, true};
    fit = FitBundle(problem, fit.state);
    const double score = MedianResidual(fit);
    if (!(score < least)) continue;
    least = score;
    best = fit.state;
  }
  return best;
}

}  // namespace kawara::vision
