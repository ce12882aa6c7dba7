#include "vision/calibration/bundle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.hpp"
#include "vision/refine/so3.hpp"

namespace kawara::vision {
namespace {

constexpr int kRobustRounds = 6;
constexpr int kIterations = 30;
/// Cauchy's scale, and where a corner is left out, in deviations of a coordinate.
constexpr double kCauchy = 2.5, kOutlier = 5.0;
/// Corners are never all better than this [px].
constexpr double kLeastSd = 1e-6;

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Normal equations: B of the shared numbers, a block a view.
struct Normal {
  Eigen::MatrixXd shared;
  Eigen::VectorXd shared_right;
  std::vector<Matrix6d> view;
  std::vector<Vector6d> view_right;
  std::vector<Eigen::MatrixXd> cross;  ///< shared x 6
};

class Adjuster {
 public:
  Adjuster(const BundleProblem& problem, const BundleState& start)
      : problem_(problem),
        info_(TrialCamera::ParametersOf(problem.model, problem.picture)),
        views_(*problem.views) {
    fit_.state = start;
    for (std::size_t i = 0; i < info_.size(); ++i) {
      if (i >= problem.fixed.size() || !problem.fixed[i]) {
        free_.push_back(static_cast<Eigen::Index>(i));
      }
    }
    for (const BoardView& view : views_) {
      weights_.emplace_back(view.size(), 1.0);
      fit_.used.emplace_back(view.size(), true);
    }
    Clamp(fit_.state.parameters);
  }

  BundleFit Run() {
    double cost = Residuals(fit_.state, fit_.residuals);
    if (!std::isfinite(cost)) return fit_;
    for (int round = 0; round < kRobustRounds; ++round) {
      Weigh();
      Minimise();
    }
    // Twice: what is left out moves the rest a little.
    for (int round = 0; round < 2; ++round) {
      LeaveOut();
      Minimise();
    }
    Conclude();
    return fit_;
  }

 private:
  void Clamp(Eigen::VectorXd& parameters) const {
    for (std::size_t i = 0; i < info_.size(); ++i) {
      double& p = parameters[static_cast<Eigen::Index>(i)];
      p = std::clamp(p, info_[i].low, info_[i].high);
    }
  }

  Eigen::Vector3d Point(const BundleState& state, std::size_t view, std::size_t corner) const {
    const Eigen::Vector2d on_board = views_[view][corner].OnBoard(problem_.square_m);
    return state.optical_from_board[view] * Eigen::Vector3d(on_board.x(), on_board.y(), 0.0);
  }

  /// The weighted sum of squares; not finite where the camera has no image of a corner.
  double Residuals(const BundleState& state,
                   std::vector<std::vector<Eigen::Vector2d>>& residuals) const {
    const TrialCamera camera(problem_.model, problem_.picture, state.parameters);
    residuals.resize(views_.size());
    double cost = 0.0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      residuals[v].resize(views_[v].size());
      for (std::size_t c = 0; c < views_[v].size(); ++c) {
        residuals[v][c] = views_[v][c].pixel_px - camera.Project(Point(state, v, c));
        if (fit_.used[v][c]) cost += weights_[v][c] * residuals[v][c].squaredNorm();
      }
    }
    return cost;
  }

  Normal Build() const {
    const auto n = static_cast<Eigen::Index>(free_.size());
    Normal normal;
    normal.shared = Eigen::MatrixXd::Zero(n, n);
    normal.shared_right = Eigen::VectorXd::Zero(n);
    const Eigen::VectorXd& now = fit_.state.parameters;
    const TrialCamera camera(problem_.model, problem_.picture, now);
    // One-sided at a bound.
    struct Neighbours {
      TrialCamera low, high;
      double span;
    };
    std::vector<Neighbours> beside;
    for (const Eigen::Index i : free_) {
      const TrialParameter& info = info_[static_cast<std::size_t>(i)];
      Eigen::VectorXd low = now, high = now;
      low[i] = std::max(info.low, now[i] - info.step);
      high[i] = std::min(info.high, now[i] + info.step);
      beside.push_back({TrialCamera(problem_.model, problem_.picture, low),
                        TrialCamera(problem_.model, problem_.picture, high), high[i] - low[i]});
    }
    Eigen::MatrixXd by_shared(2, n);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Matrix6d block = Matrix6d::Zero();
      Vector6d right = Vector6d::Zero();
      Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(n, 6);
      const Eigen::Isometry3d& pose = fit_.state.optical_from_board[v];
      for (std::size_t c = 0; c < views_[v].size(); ++c) {
        if (!fit_.used[v][c]) continue;
        const Eigen::Vector3d point = Point(fit_.state, v, c);
        Eigen::Matrix<double, 2, 3> by_ray;
        camera.Project(point, &by_ray);
        Eigen::Matrix<double, 2, 6> by_pose;
        by_pose.leftCols<3>() = -by_ray * Skew(point - pose.translation());
        by_pose.rightCols<3>() = by_ray;
        for (Eigen::Index k = 0; k < n; ++k) {
          const Neighbours& b = beside[static_cast<std::size_t>(k)];
          by_shared.col(k) = (b.high.Project(point) - b.low.Project(point)) / b.span;
        }
        const double w = weights_[v][c];
        const Eigen::Vector2d r = fit_.residuals[v][c];
        normal.shared += w * by_shared.transpose() * by_shared;
        normal.shared_right += w * by_shared.transpose() * r;
        block += w * by_pose.transpose() * by_pose;
        right += w * by_pose.transpose() * r;
        cross += w * by_shared.transpose() * by_pose;
      }
      normal.view.push_back(block);
      normal.view_right.push_back(right);
      normal.cross.push_back(cross);
    }
    return normal;
  }

  BundleState Stepped(const Normal& normal, double damping) const {
    Eigen::MatrixXd reduced = normal.shared;
    reduced.diagonal() += damping * normal.shared.diagonal();
    Eigen::VectorXd right = normal.shared_right;
    std::vector<Eigen::LDLT<Matrix6d>> solvers;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Matrix6d block = normal.view[v];
      block.diagonal() += damping * normal.view[v].diagonal();
      block.diagonal().array() += 1e-12;  // of a view without corners
      solvers.emplace_back(block);
      reduced -= normal.cross[v] * solvers[v].solve(normal.cross[v].transpose());
      right -= normal.cross[v] * solvers[v].solve(normal.view_right[v]);
    }
    BundleState next = fit_.state;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(right.size());
    if (!free_.empty()) {
      // Numbers are of very different sizes.
      const Eigen::VectorXd scale = reduced.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
      const Eigen::MatrixXd scaled = scale.asDiagonal() * reduced * scale.asDiagonal();
      step = scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * right);
    }
    for (std::size_t k = 0; k < free_.size(); ++k) {
      next.parameters[free_[k]] += step[static_cast<Eigen::Index>(k)];
    }
    Clamp(next.parameters);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const Vector6d move =
          solvers[v].solve(normal.view_right[v] - normal.cross[v].transpose() * step);
      Eigen::Isometry3d& pose = next.optical_from_board[v];
      pose.linear() = Exp(move.head<3>()) * pose.linear();
      pose.translation() += move.tail<3>();
    }
    return next;
  }

  void Minimise() {
    double damping = 1e-4;
    double cost = Residuals(fit_.state, fit_.residuals);
    for (int i = 0; i < kIterations; ++i, ++fit_.iterations) {
      const Normal normal = Build();
      bool better = false;
      double gain = 0.0;
      while (damping < 1e8) {
        BundleState next = Stepped(normal, damping);
        std::vector<std::vector<Eigen::Vector2d>> residuals;
        const double next_cost = Residuals(next, residuals);
        if (next_cost < cost) {  // false if it is no number
          gain = (cost - next_cost) / cost;
          cost = next_cost;
          fit_.state = std::move(next);
          fit_.residuals = std::move(residuals);
          damping = std::max(1e-12, 0.2 * damping);
          better = true;
          break;
        }
        damping *= 5.0;
      }
      if (!better || gain < 1e-10) return;
    }
  }

  /// Of a coordinate, by the median distance: of Rayleigh's law.
  double RobustSd() const {
    std::vector<double> distances;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (std::size_t c = 0; c < views_[v].size(); ++c) {
        distances.push_back(fit_.residuals[v][c].norm());
      }
    }
    if (distances.empty()) return kLeastSd;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::ranges::nth_element(distances, middle);
    return std::max(kLeastSd, *middle / std::sqrt(2.0 * std::log(2.0)));
  }

  void Weigh() {
    const double scale = kCauchy * RobustSd();
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (std::size_t c = 0; c < views_[v].size(); ++c) {
        const double distance = fit_.residuals[v][c].norm() / scale;
        weights_[v][c] = 1.0 / (1.0 + distance * distance);
      }
    }
  }

  void LeaveOut() {
    const double limit = kOutlier * RobustSd();
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (std::size_t c = 0; c < views_[v].size(); ++c) {
        fit_.used[v][c] = fit_.residuals[v][c].norm() <= limit;
        weights_[v][c] = 1.0;
      }
    }
  }

  void Conclude() {
    double sum = 0.0;
    std::size_t corners = 0, poses = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const std::size_t before = corners;
      for (std::size_t c = 0; c < views_[v].size(); ++c) {
        if (!fit_.used[v][c]) continue;
        sum += fit_.residuals[v][c].squaredNorm();
        ++corners;
      }
      poses += corners > before ? 1 : 0;
    }
    const double freedom = 2.0 * static_cast<double>(corners) - 6.0 * static_cast<double>(poses) -
                           static_cast<double>(free_.size());
    fit_.rms_px = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, corners)));
    fit_.sd_px = std::sqrt(sum / std::max(1.0, freedom));
    const auto all = static_cast<Eigen::Index>(info_.size());
    fit_.covariance = Eigen::MatrixXd::Zero(all, all);
    if (freedom < 1.0 || free_.empty()) return;
    const Normal normal = Build();
    Eigen::MatrixXd reduced = normal.shared;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Matrix6d block = normal.view[v];
      block.diagonal().array() += 1e-12;
      reduced -= normal.cross[v] * block.ldlt().solve(normal.cross[v].transpose());
    }
    const Eigen::VectorXd scale = reduced.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * reduced * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
    fit_.determined = solver.eigenvalues()[0] > 1e-15;
    const Eigen::VectorXd inverse = solver.eigenvalues().cwiseMax(1e-16).cwiseInverse();
    const Eigen::MatrixXd covariance = fit_.sd_px * fit_.sd_px * scale.asDiagonal() *
                                       solver.eigenvectors() * inverse.asDiagonal() *
                                       solver.eigenvectors().transpose() * scale.asDiagonal();
    for (std::size_t a = 0; a < free_.size(); ++a) {
      for (std::size_t b = 0; b < free_.size(); ++b) {
        fit_.covariance(free_[a], free_[b]) =
            covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      }
    }
  }

  const BundleProblem& problem_;
  std::vector<TrialParameter> info_;
  const std::vector<BoardView>& views_;
  std::vector<Eigen::Index> free_;
  std::vector<std::vector<double>> weights_;
  BundleFit fit_;
};

}  // namespace

BundleFit FitBundle(const BundleProblem& problem, const BundleState& start) {
  CORE_CHECK(problem.views != nullptr && problem.views->size() == start.optical_from_board.size());
  return Adjuster(problem, start).Run();
}

double ViewRms(const BundleProblem& problem, const Eigen::VectorXd& parameters,
               const BoardView& view, const Eigen::Isometry3d& start) {
  const std::vector<BoardView> one{view};
  BundleProblem alone = problem;
  alone.views = &one;
  alone.fixed.assign(static_cast<std::size_t>(parameters.size()), true);
  const BundleFit fit = FitBundle(alone, {parameters, {start}});
  return fit.iterations > 0 ? fit.rms_px : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace kawara::vision
