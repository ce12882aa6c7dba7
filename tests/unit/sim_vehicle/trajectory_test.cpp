#include "sim/vehicle/trajectory.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "tests/unit/sim_vehicle/test_drives.hpp"

namespace kawara::sim {
namespace {

struct Case {
  const char* name;
  VehicleConfig vehicle;
  PathConfig path;
  GroundHeight ground;
};

class TrajectoryOf : public ::testing::TestWithParam<Case> {
 protected:
  Trajectory trajectory =
      Trajectory::Make(GetParam().vehicle, GetParam().path, kOrigin, kBegin, GetParam().ground, 5)
          .value();
  double duration_s = core::ToSeconds(trajectory.end() - trajectory.begin());
};

/// Turn that takes the axes of `a` to those of `b`, in body axes.
Eigen::Vector3d TurnBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::AngleAxisd turn(a.transpose() * b);
  return turn.angle() * turn.axis();
}

TEST_P(TrajectoryOf, DerivativesAreThoseOfTheMotion) {
  constexpr double kStep_s = 1e-4;
  for (double t = 0.0137; t < duration_s; t += 0.0731) {
    const MotionState before = trajectory.AtSeconds(t - kStep_s);
    const MotionState now = trajectory.AtSeconds(t);
    const MotionState after = trajectory.AtSeconds(t + kStep_s);
    const Eigen::Vector3d velocity =
        (after.position_enu_m - before.position_enu_m) / (2.0 * kStep_s);
    const Eigen::Vector3d acceleration =
        (after.velocity_enu_mps - before.velocity_enu_mps) / (2.0 * kStep_s);
    const Eigen::Vector3d rate = TurnBetween(before.R_enu_body, after.R_enu_body) / (2.0 * kStep_s);
    const Eigen::Vector3d rate_dot =
        (after.rate_body_radps - before.rate_body_radps) / (2.0 * kStep_s);
    ASSERT_LT((velocity - now.velocity_enu_mps).norm(), 1e-6) << t;
    ASSERT_LT((acceleration - now.acceleration_enu_mps2).norm(), 1e-4) << t;
    ASSERT_LT((rate - now.rate_body_radps).norm(), 1e-6) << t;
    ASSERT_LT((rate_dot - now.rate_dot_body_radps2).norm(), 1e-4) << t;
  }
}

TEST_P(TrajectoryOf, LeverArmsMoveWithTheBody) {
  constexpr double kStep_s = 1e-4;
  const Eigen::Vector3d lever(0.7, -0.3, -1.1);
  for (double t = 10.0; t < duration_s; t += 0.931) {
    const MotionState before = trajectory.AtSeconds(t - kStep_s);
    const MotionState now = trajectory.AtSeconds(t);
    const MotionState after = trajectory.AtSeconds(t + kStep_s);
    const Eigen::Vector3d velocity =
        (after.PointEnu(lever) - before.PointEnu(lever)) / (2.0 * kStep_s);
    const Eigen::Vector3d acceleration =
        (after.PointVelocityEnu(lever) - before.PointVelocityEnu(lever)) / (2.0 * kStep_s);
    ASSERT_LT((velocity - now.PointVelocityEnu(lever)).norm(), 1e-6) << t;
    ASSERT_LT((acceleration - now.PointAccelerationEnu(lever)).norm(), 1e-4) << t;
  }
}

TEST_P(TrajectoryOf, TurningPointNeverSlipsSideways) {
  const VehicleConfig& v = GetParam().vehicle;
  const Eigen::Vector3d turning_point(v.turning_point_forward_m, 0.0, v.reference_height_m);
  for (double t = 0.0; t < duration_s; t += 0.05) {
    const MotionState s = trajectory.AtSeconds(t);
    const Eigen::Vector3d velocity = s.PointVelocityEnu(turning_point);
    const double yaw = s.attitude.yaw_rad;
    // The heave moves it up and down; seen from above it goes where the nose points.
    ASSERT_NEAR(velocity.x() * std::cos(yaw) - velocity.y() * std::sin(yaw), 0.0, 1e-9) << t;
  }
}

TEST_P(TrajectoryOf, KeepsItsLimits) {
  VehicleConfig calm = GetParam().vehicle;
  calm.vibration.roll_rms_deg = calm.vibration.pitch_rms_deg = calm.vibration.heave_rms_m = 0.0;
  calm.reference_height_m = 0.0;
  calm.turning_point_forward_m = 0.0;
  const Trajectory level = Trajectory::Make(calm, GetParam().path, kOrigin, kBegin, {}, 5).value();
  const MotionLimits& limits = calm.limits;
  double fastest = 0.0;
  double last_along = 0.0;
  for (double t = 0.0; t < core::ToSeconds(level.end() - level.begin()); t += 0.01) {
    const MotionState s = level.AtSeconds(t);
    const Eigen::Vector3d ahead = s.R_enu_body.col(0);
    const double along = s.acceleration_enu_mps2.dot(ahead);
    const double across = s.acceleration_enu_mps2.dot(s.R_enu_body.col(1));
    ASSERT_LT(along, limits.acceleration_mps2 * 1.01) << t;
    ASSERT_GT(along, -limits.deceleration_mps2 * 1.01) << t;
    ASSERT_LT(std::abs(across), limits.lateral_mps2 * 1.2)
        << t;  // smoothed in time only afterwards
    ASSERT_LT(std::abs(along - last_along) / 0.01, limits.jerk_mps3 * 1.1) << t;
    ASSERT_LT(s.rate_body_radps.norm(), limits.turn_rate_degps * core::kRadFromDeg * 1.15) << t;
    const double speed = s.velocity_enu_mps.norm();
    if (speed > 0.05 && calm.min_turning_radius_m > 0.0) {
      ASSERT_LT(s.rate_body_radps.norm() / speed, 1.0 / calm.min_turning_radius_m) << t;
    }
    fastest = std::max(fastest, speed);
    last_along = along;
  }
  EXPECT_GT(fastest, GetParam().path.speed_mps * 0.95) << "it does reach the speed wished";
}

TEST_P(TrajectoryOf, StandsStillForAlignmentButForTheIdleShake) {
  const VehicleConfig& v = GetParam().vehicle;
  const MotionState first = trajectory.AtSeconds(0.0);
  for (double t = -5.0; t < GetParam().path.stand_before_s; t += 0.05) {
    const MotionState s = trajectory.AtSeconds(t);
    ASSERT_LT((s.position_enu_m - first.position_enu_m).norm(),
              v.vibration.idle_share * 10.0 * v.vibration.heave_rms_m + 5e-4);
    ASSERT_NEAR(s.attitude.yaw_rad, first.attitude.yaw_rad, 1e-12);
  }
}

TEST_P(TrajectoryOf, BeginsAndEndsAtTheWaypointsOnTheGround) {
  const VehicleConfig& v = GetParam().vehicle;
  const Eigen::Vector3d turning_point(v.turning_point_forward_m, 0.0, v.reference_height_m);
  const auto near = [&](double t, const Waypoint& w) {
    const Eigen::Vector3d at = trajectory.AtSeconds(t).PointEnu(turning_point);
    const GroundHeight& ground = GetParam().ground;
    EXPECT_NEAR(at.x(), w.east_m, 1e-9);
    EXPECT_NEAR(at.y(), w.north_m, 1e-9);
    // Wheels around it stand on a plane through a curved ground.
    EXPECT_NEAR(at.z(), ground ? ground(w.east_m, w.north_m) : 0.0, 0.02);
  };
  near(0.0, GetParam().path.waypoints.front());
  near(duration_s, GetParam().path.waypoints.back());
}

INSTANTIATE_TEST_SUITE_P(All, TrajectoryOf,
                         ::testing::Values(Case{"RobotOnHills", Robot(), RobotPath(), Hills},
                                           Case{"CarOnHills", Car(), CarPath(), Hills},
                                           Case{"RobotLevel", Robot(), RobotPath(), {}}),
                         [](const auto& c) { return std::string(c.param.name); });

TEST(Trajectory, RollPitchAndHeightAreThoseOfASlope) {
  VehicleConfig robot = Robot();
  robot.vibration.idle_share = 0.0;
  PathConfig path;
  path.waypoints = {{0, 0, {}, 0}, {0, 10, {}, 0}};  // north, on ground rising to north and east
  const auto slope = [](double east, double north) { return 0.1 * north + 0.05 * east + 2.0; };
  const Trajectory t = Trajectory::Make(robot, path, kOrigin, kBegin, slope, 1).value();
  const MotionState s = t.AtSeconds(0.0);
  EXPECT_NEAR(s.attitude.pitch_rad, std::atan(0.1), 1e-9) << "nose up";
  EXPECT_LT(s.attitude.roll_rad, 0.0) << "right side up is roll to the left";
  // Body down is the slope's normal.
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.05, -0.1, 1.0).normalized();
  EXPECT_LT((s.R_enu_body.col(2) + normal).norm(), 1e-9);
  const Eigen::Vector3d ground =
      s.PointEnu({robot.turning_point_forward_m, 0.0, robot.reference_height_m});
  EXPECT_NEAR(ground.z(), 2.0, 1e-9);
}

TEST(Trajectory, VibrationHasItsSizeAtTheReferenceSpeed) {
  VehicleConfig robot = Robot();
  PathConfig path;
  path.speed_mps = robot.vibration.reference_speed_mps;
  path.waypoints = {{0, 0, {}, 0}, {100, 0, {}, 0}};
  const Trajectory t = Trajectory::Make(robot, path, kOrigin, kBegin, {}, 9).value();
  double roll = 0.0;
  double pitch = 0.0;
  double heave = 0.0;
  int n = 0;
  for (double s = 20.0; s < 100.0; s += 0.013, ++n) {
    const MotionState m = t.AtSeconds(s);
    roll += std::pow(m.attitude.roll_rad * core::kDegFromRad, 2);
    pitch += std::pow(m.attitude.pitch_rad * core::kDegFromRad, 2);
    heave +=
        std::pow(m.PointEnu({robot.turning_point_forward_m, 0.0, robot.reference_height_m}).z(), 2);
  }
  EXPECT_NEAR(std::sqrt(roll / n), robot.vibration.roll_rms_deg, 0.05);
  EXPECT_NEAR(std::sqrt(pitch / n), robot.vibration.pitch_rms_deg, 0.05);
  EXPECT_NEAR(std::sqrt(heave / n), robot.vibration.heave_rms_m, 0.0004);
}

TEST(Trajectory, TrueHeadingIsThatOfThePlaceNotOfTheOrigin) {
  PathConfig path;
  path.waypoints = {{5000, 0, {}, 0}, {5000, 10, {}, 0}};
  const Trajectory t = Trajectory::Make(Robot(), path, kOrigin, kBegin, {}, 1).value();
  // Meridians converge: 5 km east of the origin, grid north lies east of true north by
  // east / (a cos(lat)) sin(lat).
  const double convergence = 5000.0 / 6378137.0 * std::tan(kOrigin.lat_rad);
  EXPECT_NEAR(t.AttitudeAt(t.begin()).yaw_rad, convergence, 0.01 * convergence);
}

TEST(Trajectory, ImpossiblePathsAreRefusedByName) {
  const struct {
    PathConfig path;
    VehicleConfig vehicle;
    const char* must_say;
  } cases[] = {
      {{.waypoints = {{0, 0, {}, 0}}}, Robot(), "two waypoints"},
      {{.waypoints = {{0, 0, {}, 0}, {5, 0, {}, 0}, {5, 0.01, {}, 0}}}, Robot(), "waypoints[2]"},
      {{.waypoints = {{0, 0, {}, 0}, {4, 0, {}, 0}, {4, 4, {}, 0}}},
       Car(),
       "waypoints[1]: a turn by 90"},
      {{.waypoints = {{0, 0, {}, 0}, {50, 0, {}, 0}, {0, 1, {}, 0}}}, Car(), "waypoints[1]"},
  };
  for (const auto& c : cases) {
    const auto made = Trajectory::Make(c.vehicle, c.path, kOrigin, kBegin, {}, 1);
    ASSERT_FALSE(made) << c.must_say;
    EXPECT_NE(made.error().message.find(c.must_say), std::string::npos) << made.error().message;
  }
}

}  // namespace
}  // namespace kawara::sim
