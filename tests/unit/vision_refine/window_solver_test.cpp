#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/geodesy.hpp"
#include "vision/refine/so3.hpp"
#include "vision/refine/window_problem.hpp"

namespace kawara::vision {
namespace {

constexpr double kRaySd = 0.3 / 272.0;
constexpr double kPositionSd = 0.02;
constexpr double kAttitudeSd = 0.1 * core::kRadFromDeg;
constexpr double kStep = 0.25;

/// A straight street, seen by a camera that drives along it with a little sway; no pictures.
struct World {
  WindowProblem problem;
  std::vector<Eigen::Isometry3d> truth;

  World(std::uint32_t seed, std::size_t frames, const RigState& rig = {}) : dice(seed) {
    problem.ray_sd_rad = kRaySd;
    problem.rig_information =
        1e12 * RigInformation::Identity();  // known, unless a test says otherwise
    Eigen::Isometry3d mounting = Eigen::Isometry3d::Identity();
    mounting.translation() = Eigen::Vector3d(0.1, 0.2, -1.0);
    mounting.linear() = Exp({0.3, 1.2, -0.4});
    problem.body_from_camera = {mounting};
    for (std::size_t i = 0; i < frames; ++i) AddFrame(static_cast<double>(i), rig);
    for (int i = 0; i < 1500; ++i) AddPoint();
  }

  double Normal(double sd) { return std::normal_distribution<double>(0.0, sd)(dice); }
  double Uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(dice); }
  Eigen::Vector3d Normals(double sd) { return {Normal(sd), Normal(sd), Normal(sd)}; }

  void AddFrame(double i, const RigState& rig) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(kStep * i, 0.05 * std::sin(0.5 * i), 1.0);
    pose.linear() =
        Exp({0.01 * std::sin(0.7 * i), 0.01 * std::cos(0.9 * i), 0.1 * std::sin(0.3 * i)});
    truth.push_back(pose);
    WindowFrame frame;
    frame.velocity_mps = Eigen::Vector3d(1.5, 0.15 * std::cos(0.5 * i), 0.0);
    frame.rate_radps = Eigen::Vector3d(0.0, 0.0, 0.18 * std::cos(0.3 * i));
    frame.prior = pose;
    frame.prior.translation() += Normals(kPositionSd) - rig.time_offset_s * frame.velocity_mps;
    frame.prior.linear() =
        pose.linear() *
        Exp(-rig.mounting_rad - rig.time_offset_s * frame.rate_radps + Normals(kAttitudeSd));
    frame.covariance.diagonal().head<3>().setConstant(kPositionSd * kPositionSd);
    frame.covariance.diagonal().tail<3>().setConstant(kAttitudeSd * kAttitudeSd);
    problem.frames.push_back(frame);
  }

  /// On the ground or a wall, seen within 8 m by up to 15 frames.
  void AddPoint() {
    const double length = kStep * static_cast<double>(truth.size() - 1);
    Eigen::Vector3d place(Uniform(-4.0, length + 4.0), 0.0, 0.0);
    switch (std::uniform_int_distribution<int>(0, 2)(dice)) {
      case 0:
        place.y() = Uniform(-4.0, 4.0);
        break;
      case 1:
        place.y() = 6.0, place.z() = Uniform(0.0, 6.0);
        break;
      default:
        place.y() = -5.0, place.z() = Uniform(0.0, 6.0);
    }
    WindowPoint point;
    for (std::size_t i = 0; i < truth.size() && point.sightings.size() < 15; ++i) {
      const Eigen::Vector3d seen = (truth[i] * problem.body_from_camera[0]).inverse() * place;
      if (seen.norm() > 8.0) continue;
      const Eigen::Vector3d ray = seen.normalized();
      point.sightings.push_back({i, 0, (ray + ray.cross(Normals(kRaySd))).normalized()});
    }
    if (point.sightings.size() >= 2) problem.points.push_back(point);
  }

  std::mt19937 dice;
};

struct Quality {
  double pair_turn_deg = 0.0, length = 0.0, position_m = 0.0, attitude_deg = 0.0;
};

/// Root mean squares; pairs are two frames apart, half a metre.
Quality Judge(const std::vector<World>& worlds,
              const std::vector<std::vector<Eigen::Isometry3d>>& all) {
  Quality sums;
  double pairs = 0.0, frames = 0.0;
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    const auto& poses = all[w];
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Isometry3d& truth = worlds[w].truth[i];
      sums.position_m += (poses[i].translation() - truth.translation()).squaredNorm() / 3.0;
      sums.attitude_deg += Log(truth.linear().transpose() * poses[i].linear()).squaredNorm() / 3.0;
      ++frames;
      if (i + 2 >= poses.size()) continue;
      const Eigen::Isometry3d step = poses[i].inverse() * poses[i + 2];
      const Eigen::Isometry3d true_step = truth.inverse() * worlds[w].truth[i + 2];
      sums.pair_turn_deg += Log(true_step.linear().transpose() * step.linear()).squaredNorm();
      const double ratio = step.translation().norm() / true_step.translation().norm() - 1.0;
      sums.length += ratio * ratio;
      ++pairs;
    }
  }
  return {std::sqrt(sums.pair_turn_deg / pairs) / core::kRadFromDeg, std::sqrt(sums.length / pairs),
          std::sqrt(sums.position_m / frames),
          std::sqrt(sums.attitude_deg / frames) / core::kRadFromDeg};
}

std::vector<World> Worlds(std::size_t frames, const RigState& rig = {}) {
  std::vector<World> worlds;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) worlds.emplace_back(seed, frames, rig);
  return worlds;
}

TEST(WindowSolver, PicturesGiveTurnsAndLengthsThatPosesDoNot) {
  const auto worlds = Worlds(21);
  std::vector<std::vector<Eigen::Isometry3d>> before, after;
  for (const World& world : worlds) {
    before.emplace_back();
    for (const WindowFrame& frame : world.problem.frames) before.back().push_back(frame.prior);
    after.push_back(SolveWindow(world.problem).poses);
  }
  const Quality raw = Judge(worlds, before), refined = Judge(worlds, after);
  EXPECT_GT(raw.pair_turn_deg, 0.2);
  EXPECT_LT(refined.pair_turn_deg, 0.02);
  EXPECT_LT(refined.length, 0.004);
  EXPECT_LT(refined.position_m, 0.01);
  EXPECT_LT(refined.attitude_deg, 0.04);
}

TEST(WindowSolver, ExactPosesAndRaysStay) {
  World world(1, 11);
  for (std::size_t i = 0; i < world.truth.size(); ++i) {
    world.problem.frames[i].prior = world.truth[i];
    world.problem.frames[i].covariance *= 1e-4;
  }
  const WindowSolution solution = SolveWindow(world.problem);
  for (std::size_t i = 0; i < world.truth.size(); ++i) {
    EXPECT_LT((solution.poses[i].translation() - world.truth[i].translation()).norm(), 1e-3);
    EXPECT_LT(Log(world.truth[i].linear().transpose() * solution.poses[i].linear()).norm(), 1e-4);
  }
  EXPECT_NEAR(solution.ray_rms, 1.0, 0.1);
}

TEST(WindowSolver, PointsThatContradictTheOthersAreLeftOut) {
  World world(2, 15);
  // A seventh is on something that drives along.
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < world.problem.points.size(); i += 7, ++wrong) {
    for (Sighting& sighting : world.problem.points[i].sightings) {
      sighting.ray = (Exp({0.0, 0.0, 0.01 * static_cast<double>(sighting.frame * sighting.frame)}) *
                      sighting.ray)
                         .normalized();
    }
  }
  const WindowSolution solution = SolveWindow(world.problem);
  const std::vector<World> worlds{world};
  const Quality refined = Judge(worlds, {solution.poses});
  EXPECT_LT(refined.pair_turn_deg, 0.02);
  std::size_t dropped = 0;
  for (const bool used : solution.point_used) dropped += used ? 0 : 1;
  EXPECT_GT(static_cast<double>(dropped), 0.6 * static_cast<double>(wrong));
}

TEST(WindowSolver, MountingAndTimeOffsetAreFoundWithTheDeviationTheyState) {
  const RigState rig{.mounting_rad = {0.002, -0.004, 0.005}, .time_offset_s = 0.02};
  Eigen::Vector4d sd_before;
  sd_before << Eigen::Vector3d::Constant(0.005), 0.05;
  Eigen::Vector4d square = Eigen::Vector4d::Zero();
  for (const World& world : Worlds(41, rig)) {
    WindowProblem problem = world.problem;
    problem.rig_information = sd_before.cwiseAbs2().cwiseInverse().asDiagonal();
    const WindowSolution solution = SolveWindow(problem);
    Eigen::Vector4d error;
    error << solution.rig.mounting_rad - rig.mounting_rad,
        solution.rig.time_offset_s - rig.time_offset_s;
    const Eigen::Vector4d sd = solution.rig_information.inverse().diagonal().cwiseSqrt();
    square += error.cwiseQuotient(sd).cwiseAbs2();
    EXPECT_LT(sd(1), 0.0012);  // pitch and yaw: from the direction of ten metres of drive
    EXPECT_LT(sd(2), 0.0012);
    EXPECT_LT(sd(3), 0.004);
  }
  // Four draws: chi squares of four degrees of freedom stay below 14.9 in 99.5 % of cases.
  for (int k = 0; k < 4; ++k) EXPECT_LT(square(k), 14.9) << k;
}

TEST(WindowSolver, StatedCovarianceHolds) {
  double square = 0.0, count = 0.0;
  for (const World& world : Worlds(21)) {
    const WindowSolution solution = SolveWindow(world.problem);
    for (std::size_t i = 0; i < world.truth.size(); i += 5) {
      Eigen::Matrix<double, 6, 1> error;
      error << solution.poses[i].translation() - world.truth[i].translation(),
          Log(world.truth[i].linear().transpose() * solution.poses[i].linear());
      const auto at = 6 * static_cast<Eigen::Index>(i);
      square += error.dot(solution.covariance.block<6, 6>(at, at).inverse() * error);
      count += 6.0;
    }
  }
  EXPECT_GT(square / count, 0.4);
  EXPECT_LT(square / count, 2.0);
}

}  // namespace
}  // namespace kawara::vision
