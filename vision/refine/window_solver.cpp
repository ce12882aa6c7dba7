#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.hpp"
#include "vision/refine/so3.hpp"
#include "vision/refine/window_problem.hpp"

namespace kawara::vision {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix63d = Eigen::Matrix<double, 6, 3>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;
using Matrix64d = Eigen::Matrix<double, 6, 4>;

constexpr int kIterations = 12;
/// After these the poses are good enough to see which points cannot be.
constexpr int kRough = 2;
/// Residuals beyond this many deviations count less and less (Cauchy).
constexpr double kRobust = 2.5;
/// A point whose sightings differ by more than this from what all points say [deviations, rms;
/// while the poses are rough, as many times more as most points do].
constexpr double kContradiction = 3.5;
/// Nearer than this [1 / m] nothing is.
constexpr double kNearest = 4.0;
constexpr double kFirstDamping = 1e-6;
/// Steps smaller than these end the iteration [m, rad].
constexpr double kStillMetres = 2e-5, kStillRadians = 2e-6;

/// A point as direction and inverse distance from a fixed origin, the place of one of its cameras:
/// what lies far away is as well-behaved as what is near.
struct Point {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< unit
  double inverse_m = 0.0;
  bool used = false;
};

/// What a sighting says, linearised. Residuals in deviations.
struct Linear {
  Eigen::Vector2d residual;
  Matrix26d by_pose;
  Eigen::Matrix<double, 2, 3> by_point;
};

/// Two unit vectors that stand across `ray` and each other, as columns.
Eigen::Matrix<double, 3, 2> Across(const Eigen::Vector3d& ray) {
  const Eigen::Vector3d other =
      std::abs(ray.x()) < 0.7 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = ray.cross(other).normalized();
  across.col(1) = ray.cross(across.col(0));
  return across;
}

class Solver {
 public:
  Solver(const WindowProblem& problem, const std::vector<Eigen::Isometry3d>& start)
      : problem_(problem),
        frames_(problem.frames.size()),
        unknowns_(6 * static_cast<Eigen::Index>(frames_) + 4),
        rig_(problem.rig) {
    CORE_CHECK(start.empty() || start.size() == frames_);
    for (std::size_t i = 0; i < frames_; ++i) {
      poses_.push_back(start.empty() ? problem.frames[i].prior : start[i]);
      prior_information_.push_back(problem.frames[i].covariance.inverse());
    }
    for (const WindowPoint& point : problem.points) {
      points_.push_back(Triangulate(point));
    }
  }

  WindowSolution Solve() {
    double damping = kFirstDamping;
    WindowSolution solution;
    double cost = Cost();
    int cleaned = 0;
    for (int k = 0; k < kIterations; ++k) {
      ++solution.iterations;
      Linearise();
      const auto before_poses = poses_;
      const auto before_points = points_;
      const RigState before_rig = rig_;
      const double moved = Step(damping);
      const double now = Cost();
      if (!(now <= cost * (1.0 + 1e-9))) {
        poses_ = before_poses;
        points_ = before_points;
        rig_ = before_rig;
        damping *= 30.0;
        if (damping > 1e3) break;
        continue;
      }
      damping = std::max(kFirstDamping, damping / 10.0);
      const bool still = moved < 1.0 || cost - now < 1e-4 * cost;
      cost = now;
      if (!still && !(cleaned == 0 && k >= kRough)) continue;
      const bool dropped = cleaned < 2 && DropContradictions();
      if (still && !dropped) break;
      ++cleaned;
      width_ = 0.0;  // without them it may be narrower
      cost = Cost();
    }
    Finish(solution);
    return solution;
  }

 private:
  Eigen::Isometry3d CameraPose(const Sighting& sighting) const {
    return poses_[sighting.frame] * problem_.body_from_camera[sighting.camera];
  }

  Point Triangulate(const WindowPoint& seen) const {
    Point point;
    if (seen.sightings.size() < 2) return point;
    const Eigen::Isometry3d first = CameraPose(seen.sightings.front());
    point.origin = first.translation();
    point.direction = first.linear() * seen.sightings.front().ray;
    double top = 0.0, bottom = 0.0;
    for (const Sighting& sighting : seen.sightings) {
      const Eigen::Isometry3d pose = CameraPose(sighting);
      const Eigen::Matrix<double, 2, 3> across =
          Across(sighting.ray).transpose() * pose.linear().transpose();
      const Eigen::Vector2d a = across * (point.origin - pose.translation());
      top -= a.dot(across * point.direction);
      bottom += a.squaredNorm();
    }
    if (bottom < 1e-8) return point;  // never moved
    point.inverse_m = std::clamp(top / bottom, -0.01, kNearest);
    point.used = true;
    return point;
  }

  /// The point in the camera's axes, times its inverse distance from the origin.
  Eigen::Vector3d InCamera(const Point& point, const Sighting& sighting) const {
    const Eigen::Isometry3d pose = CameraPose(sighting);
    return pose.linear().transpose() *
           (point.direction + point.inverse_m * (point.origin - pose.translation()));
  }

  /// Squared residual in deviations.
  double Square(const Point& point, const Sighting& sighting) const {
    const Eigen::Vector3d seen = InCamera(point, sighting).normalized();
    if (seen.dot(sighting.ray) < 0.5) return 1e6;
    return seen.cross(sighting.ray).squaredNorm() / (problem_.ray_sd_rad * problem_.ray_sd_rad);
  }

  Linear LineariseSighting(const Point& point, const Sighting& sighting) const {
    const Eigen::Isometry3d& body = poses_[sighting.frame];
    const Eigen::Isometry3d& mounting = problem_.body_from_camera[sighting.camera];
    const Eigen::Matrix3d body_from_map = body.linear().transpose();
    const Eigen::Vector3d centre = body * mounting.translation();
    const Eigen::Vector3d to_origin = point.origin - centre;
    const Eigen::Vector3d in_body = body_from_map * (point.direction + point.inverse_m * to_origin);
    const Eigen::Vector3d in_camera = mounting.linear().transpose() * in_body;
    const double length = in_camera.norm();
    const Eigen::Vector3d unit = in_camera / length;
    const Eigen::Matrix<double, 2, 3> across = Across(sighting.ray).transpose();
    const double weight = 1.0 / problem_.ray_sd_rad;
    Linear linear;
    linear.residual = weight * (across * unit);
    const Eigen::Matrix<double, 2, 3> by_body =
        weight / length *
        (across * (Eigen::Matrix3d::Identity() - unit * unit.transpose()) *
         mounting.linear().transpose());
    linear.by_pose.leftCols<3>() = -point.inverse_m * (by_body * body_from_map);
    linear.by_pose.rightCols<3>() =
        by_body * (Skew(in_body) + point.inverse_m * Skew(mounting.translation()));
    linear.by_point.leftCols<2>() = by_body * body_from_map * Across(point.direction);
    linear.by_point.col(2) = by_body * body_from_map * to_origin;
    return linear;
  }

  Vector6d PriorResidual(std::size_t i) const {
    const WindowFrame& frame = problem_.frames[i];
    Vector6d residual;
    residual.head<3>() = poses_[i].translation() - frame.prior.translation() -
                         rig_.time_offset_s * frame.velocity_mps;
    residual.tail<3>() = Log(frame.prior.linear().transpose() * poses_[i].linear()) -
                         rig_.mounting_rad - rig_.time_offset_s * frame.rate_radps;
    return residual;
  }

  Eigen::Vector4d RigResidual() const {
    Eigen::Vector4d residual;
    residual << rig_.mounting_rad - problem_.rig.mounting_rad,
        rig_.time_offset_s - problem_.rig.time_offset_s;
    return residual;
  }

  /// Also sets the width of the robust kernel: never narrower than most of the residuals, so that
  /// poor first poses do not make everything an outlier.
  double Cost() {
    std::vector<double> squares;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!points_[i].used) continue;
      for (const Sighting& sighting : problem_.points[i].sightings) {
        squares.push_back(Square(points_[i], sighting));
      }
    }
    if (!squares.empty() && width_ <= 0.0) width_ = Width(squares);
    double cost = 0.0;
    for (const double square : squares) {
      cost += 0.5 * width_ * width_ * std::log1p(square / (width_ * width_));
    }
    for (std::size_t i = 0; i < frames_; ++i) {
      const Vector6d residual = PriorResidual(i);
      cost += 0.5 * residual.dot(prior_information_[i] * residual);
    }
    const Eigen::Vector4d rig = RigResidual();
    return cost + 0.5 * rig.dot(problem_.rig_information * rig);
  }

  static double Width(std::vector<double> squares) {
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return std::max(kRobust, 2.0 * std::sqrt(*middle));
  }

  /// The normal equations, points eliminated.
  void Linearise() {
    normal_ = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
    gradient_ = Eigen::VectorXd::Zero(unknowns_);
    const Eigen::Index rig = unknowns_ - 4;
    for (std::size_t i = 0; i < frames_; ++i) {
      const auto at = 6 * static_cast<Eigen::Index>(i);
      const Matrix6d& information = prior_information_[i];
      const Vector6d residual = PriorResidual(i);
      Matrix64d by_rig = Matrix64d::Zero();
      by_rig.bottomLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity();
      by_rig.col(3) << -problem_.frames[i].velocity_mps, -problem_.frames[i].rate_radps;
      normal_.block<6, 6>(at, at) += information;
      normal_.block<6, 4>(at, rig) += information * by_rig;
      normal_.block<4, 4>(rig, rig) += by_rig.transpose() * information * by_rig;
      gradient_.segment<6>(at) += information * residual;
      gradient_.segment<4>(rig) += by_rig.transpose() * information * residual;
    }
    normal_.block<4, 4>(rig, rig) += problem_.rig_information;
    gradient_.segment<4>(rig) += problem_.rig_information * RigResidual();
    eliminated_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].used) Eliminate(i);
    }
    normal_.triangularView<Eigen::StrictlyLower>() = normal_.transpose();
  }

  struct Eliminated {
    Eigen::Matrix3d inverse;
    Eigen::Vector3d gradient;
    std::vector<std::pair<std::size_t, Matrix63d>> cross;  ///< frame, its block against the point
  };

  void Eliminate(std::size_t i) {
    Eliminated& out = eliminated_[i];
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    out.gradient.setZero();
    out.cross.clear();
    for (const Sighting& sighting : problem_.points[i].sightings) {
      const Linear linear = LineariseSighting(points_[i], sighting);
      const double weight = 1.0 / (1.0 + linear.residual.squaredNorm() / (width_ * width_));
      const auto at = 6 * static_cast<Eigen::Index>(sighting.frame);
      own += weight * linear.by_point.transpose() * linear.by_point;
      out.gradient += weight * linear.by_point.transpose() * linear.residual;
      normal_.block<6, 6>(at, at) += weight * linear.by_pose.transpose() * linear.by_pose;
      gradient_.segment<6>(at) += weight * linear.by_pose.transpose() * linear.residual;
      const Matrix63d cross = weight * linear.by_pose.transpose() * linear.by_point;
      if (!out.cross.empty() && out.cross.back().first == sighting.frame) {
        out.cross.back().second += cross;
      } else {
        out.cross.emplace_back(sighting.frame, cross);
      }
    }
    own.diagonal().array() += 1e-3;  // a point nobody moved past
    out.inverse = own.inverse();
    for (std::size_t a = 0; a < out.cross.size(); ++a) {
      const auto at = 6 * static_cast<Eigen::Index>(out.cross[a].first);
      const Matrix63d weighted = out.cross[a].second * out.inverse;
      gradient_.segment<6>(at) -= weighted * out.gradient;
      for (std::size_t b = a; b < out.cross.size(); ++b) {
        normal_.block<6, 6>(at, 6 * static_cast<Eigen::Index>(out.cross[b].first)).noalias() -=
            weighted * out.cross[b].second.transpose();
      }
    }
  }

  /// How far it went, in parts of what counts as standing still.
  double Step(double damping) {
    Eigen::MatrixXd damped = normal_;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-12;
    const Eigen::VectorXd step = -damped.ldlt().solve(gradient_);
    double moved = 0.0;
    for (std::size_t i = 0; i < frames_; ++i) {
      const Vector6d part = step.segment<6>(6 * static_cast<Eigen::Index>(i));
      poses_[i].translation() += part.head<3>();
      poses_[i].linear() = poses_[i].linear() * Exp(part.tail<3>());
      moved = std::max(
          {moved, part.head<3>().norm() / kStillMetres, part.tail<3>().norm() / kStillRadians});
    }
    rig_.mounting_rad += step.segment<3>(unknowns_ - 4);
    rig_.time_offset_s += step(unknowns_ - 1);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!points_[i].used) continue;
      Eigen::Vector3d right = -eliminated_[i].gradient;
      for (const auto& [frame, cross] : eliminated_[i].cross) {
        right -= cross.transpose() * step.segment<6>(6 * static_cast<Eigen::Index>(frame));
      }
      const Eigen::Vector3d part = eliminated_[i].inverse * right;
      Point& point = points_[i];
      point.direction = (point.direction + Across(point.direction) * part.head<2>()).normalized();
      point.inverse_m = std::min(point.inverse_m + part.z(), kNearest);
    }
    return moved;
  }

  /// False: there are none.
  bool DropContradictions() {
    const double limit = kContradiction * width_ / kRobust;
    bool any = false;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!points_[i].used) continue;
      double sum = 0.0;
      for (const Sighting& sighting : problem_.points[i].sightings) {
        sum += Square(points_[i], sighting);
      }
      const auto count = static_cast<double>(problem_.points[i].sightings.size());
      if (sum / count > 2.0 * limit * limit) {
        points_[i].used = false;
        any = true;
      }
    }
    return any;
  }

  void Finish(WindowSolution& solution) {
    Linearise();
    const Eigen::Index rig = unknowns_ - 4;
    const Eigen::MatrixXd inverse =
        normal_.ldlt().solve(Eigen::MatrixXd::Identity(unknowns_, unknowns_));
    solution.poses = poses_;
    solution.covariance = inverse.topLeftCorner(rig, rig);
    solution.rig = rig_;
    // What is left for the rig once the poses are eliminated.
    const Eigen::MatrixXd poses_of_rig =
        normal_.topLeftCorner(rig, rig).ldlt().solve(normal_.topRightCorner(rig, 4));
    solution.rig_information =
        normal_.block<4, 4>(rig, rig) - normal_.bottomLeftCorner(4, rig) * poses_of_rig;
    double sum = 0.0, count = 0.0, fitted = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      solution.point_used.push_back(points_[i].used);
      if (!points_[i].used) continue;
      fitted += 3.0;
      for (const Sighting& sighting : problem_.points[i].sightings) {
        // Robustly: what a Cauchy kernel leaves of it.
        const double square = Square(points_[i], sighting);
        const double weight = 1.0 / (1.0 + square / (width_ * width_));
        sum += weight * square;
        count += weight;
      }
    }
    solution.ray_rms = 2.0 * count > fitted ? std::sqrt(sum / (2.0 * count - fitted)) : 0.0;
  }

  const WindowProblem& problem_;
  std::size_t frames_;
  Eigen::Index unknowns_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<Matrix6d> prior_information_;
  std::vector<Point> points_;
  std::vector<Eliminated> eliminated_;
  RigState rig_;
  double width_ = 0.0;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd gradient_;
};

}  // namespace

WindowSolution SolveWindow(const WindowProblem& problem,
                           const std::vector<Eigen::Isometry3d>& start) {
  return Solver(problem, start).Solve();
}

}  // namespace kawara::vision
