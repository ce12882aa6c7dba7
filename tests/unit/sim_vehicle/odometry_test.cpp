#include "sim/vehicle/odometry.hpp"

#include <gtest/gtest.h>

#include "tests/unit/sim_vehicle/test_drives.hpp"

namespace kawara::sim {
namespace {

Trajectory Drive() {
  return Trajectory::Make(Robot(), RobotPath(), kOrigin, kBegin, Hills, 2).value();
}

/// Way of the turning point along the nose.
double PathLength(const Trajectory& t, const VehicleConfig& v) {
  const Eigen::Vector3d point(v.turning_point_forward_m, 0.0, v.reference_height_m);
  double length_m = 0.0;
  for (double s = 0.0005; s < core::ToSeconds(t.end() - t.begin()); s += 0.001) {
    const MotionState state = t.AtSeconds(s);
    length_m += 0.001 * state.R_enu_body.col(0).dot(state.PointVelocityEnu(point));
  }
  return length_m;
}

TEST(Odometry, IdealWheelsCountThePathToATick) {
  const Trajectory t = Drive();
  const OdometryConfig config = OdometryConfig::Named("ideal");
  const auto samples = MeasureOdometry(t, Robot(), config, 1);
  const OdometrySample& last = samples.back();
  EXPECT_NEAR(0.5 * (last.true_left_m + last.true_right_m), PathLength(t, Robot()), 0.002);
  EXPECT_NEAR(static_cast<double>(last.left_ticks) / config.ticks_per_m, last.true_left_m, 0.0011);
  EXPECT_NEAR(static_cast<double>(last.right_ticks) / config.ticks_per_m, last.true_right_m,
              0.0011);
  // Left minus right is the turning: on level ground half of it by the track would be the heading.
  const double turned_rad = (last.true_left_m - last.true_right_m) / Robot().track_m;
  const double yaw_rad = t.AtSeconds(1e4).attitude.yaw_rad - t.AtSeconds(0.0).attitude.yaw_rad;
  EXPECT_NEAR(core::WrapPi(turned_rad - yaw_rad), 0.0, 0.03);
}

TEST(Odometry, ScaleIsDrawnForEachSideAndHoldsAllTheWay) {
  const Trajectory t = Drive();
  OdometryConfig config = OdometryConfig::Named("ideal");
  config.scale = 0.01;
  double square = 0.0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const auto samples = MeasureOdometry(t, Robot(), config, seed);
    const OdometrySample& half = samples[samples.size() / 2];
    const OdometrySample& last = samples.back();
    const double scale =
        static_cast<double>(last.left_ticks) / config.ticks_per_m / last.true_left_m - 1.0;
    EXPECT_LT(std::abs(scale), 0.0205);
    EXPECT_NEAR(static_cast<double>(half.left_ticks) / config.ticks_per_m / half.true_left_m - 1.0,
                scale, 1e-3);
    square += scale * scale / 24.0;
  }
  EXPECT_NEAR(std::sqrt(square), 0.0088, 0.003);
}

TEST(Odometry, SlipTurnsWheelsFurtherSkidsLess) {
  const Trajectory t = Drive();
  OdometryConfig slip = OdometryConfig::Named("ideal");
  slip.slip = 0.05;
  const OdometrySample slipped = MeasureOdometry(t, Robot(), slip, 3).back();
  EXPECT_NEAR(static_cast<double>(slipped.left_ticks) / slip.ticks_per_m / slipped.true_left_m,
              1.05, 0.015);

  OdometryConfig skid = OdometryConfig::Named("ideal");
  skid.skids_per_min = 6.0;
  const auto samples = MeasureOdometry(t, Robot(), skid, 3);
  int marked = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const OdometrySample& s = samples[i];
    const bool stood = s.left_ticks == samples[i - 1].left_ticks;
    const double moved_m = s.true_left_m - samples[i - 1].true_left_m;
    if (stood && moved_m > 0.01) {
      EXPECT_TRUE(s.slipping) << i;
    }
    marked += s.slipping ? 1 : 0;
  }
  EXPECT_GT(marked, 20);
  EXPECT_LT(static_cast<double>(samples.back().left_ticks) / skid.ticks_per_m,
            samples.back().true_left_m - 0.05);
}

TEST(Odometry, ItsClockRunsAsSaid) {
  OdometryConfig config = OdometryConfig::Named("ideal");
  config.clock = {.offset_s = 0.25, .skew_ppm = 500.0, .wander_ppm_per_sqrt_h = 0.0};
  const auto samples = MeasureOdometry(Drive(), Robot(), config, 1);
  const auto late = [](const OdometrySample& s) { return core::ToSeconds(s.stamp - s.time); };
  EXPECT_NEAR(late(samples.front()), 0.25, 1e-6);
  const double passed_s = core::ToSeconds(samples.back().time - samples.front().time);
  EXPECT_NEAR((late(samples.back()) - 0.25) / passed_s, 500e-6, 1e-6);
}

}  // namespace
}  // namespace kawara::sim
