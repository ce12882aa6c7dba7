#include "comms/convert.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "comms/codec.hpp"

namespace kawara::comms {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Over degrees and back costs one rounding each way; 1e-15 of an angle is 6 nm on the ground.
constexpr double kRad = 1e-15;

template <class T>
T OverTheWire(const T& message) {
  const auto decoded = Decode<T>(*Encode(message));
  EXPECT_TRUE(decoded.has_value());
  return *decoded;
}

core::Pose SomePose() {
  core::Pose pose;
  pose.time = core::GpsTime::FromNs(1'467'000'000'123'456'789);
  pose.mono = core::MonoTime::FromNs(77'000'000'001);
  pose.position = {35.6581 * core::kRadFromDeg, 139.7017 * core::kRadFromDeg, 41.25};
  pose.attitude = {0.01, -0.02, 3.0};
  pose.velocity_enu_mps = {1, 2, 3};
  pose.position_cov_enu_m2 << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  pose.attitude_sd_rad = {0.001, 0.002, 0.003};
  pose.rtk = core::RtkState::kFixed;
  pose.gnss_age_s = 0.25;
  pose.valid = true;
  return pose;
}

TEST(Convert, PoseOverAndBack) {
  const core::Pose a = SomePose();
  const auto b = FromMessage(OverTheWire(ToMessage(a)));
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(b->time, a.time);
  EXPECT_EQ(b->mono, a.mono);
  EXPECT_NEAR(b->position.lat_rad, a.position.lat_rad, kRad);
  EXPECT_NEAR(b->position.lon_rad, a.position.lon_rad, kRad);
  EXPECT_EQ(b->position.h_ellipsoidal_m, a.position.h_ellipsoidal_m);
  EXPECT_NEAR(b->attitude.yaw_rad, a.attitude.yaw_rad, kRad);
  EXPECT_EQ(b->position_cov_enu_m2, a.position_cov_enu_m2);
  EXPECT_TRUE(b->attitude_sd_rad.isApprox(a.attitude_sd_rad, 1e-14));
  EXPECT_EQ(b->rtk, a.rtk);
  EXPECT_TRUE(b->valid);
}

TEST(Convert, PoseInDegrees) {
  const pose_t message = ToMessage(SomePose());
  EXPECT_NEAR(message.lat_deg, 35.6581, 1e-13);
  EXPECT_NEAR(message.yaw_deg, 3.0 * 180.0 / M_PI, 1e-13);
}

TEST(Convert, GnssFixOverAndBack) {
  core::GnssFix a;
  a.time = core::GpsTime::FromNs(5);
  a.rtk = core::RtkState::kFloat;
  a.native_quality = 200;  // above what the message's signed byte can say directly
  a.has_position = true;
  a.antenna = {-0.5, 2.0, 10.0};
  a.position_cov_enu_m2.diagonal() << 1e-4, 4e-4, 9e-4;
  a.satellites = 14;
  a.base_station = 65535;
  a.hdop = kNaN;
  const auto b = FromMessage(OverTheWire(ToMessage(a)));
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(b->native_quality, 200);
  EXPECT_EQ(b->base_station, 65535);
  EXPECT_EQ(b->satellites, 14);
  EXPECT_TRUE(std::isnan(b->hdop));
  EXPECT_EQ(b->position_cov_enu_m2, a.position_cov_enu_m2);
  EXPECT_NEAR(b->antenna.lat_rad, a.antenna.lat_rad, kRad);
}

TEST(Convert, AhrsSampleOverAndBack) {
  core::AhrsSample a;
  a.sampled = core::MonoTime::FromNs(123);
  a.has_attitude = true;
  a.attitude = {0.1, 0.2, 0.3};
  a.rate_radps = {1, 2, 3};
  a.specific_force_mps2 = {0, 0, -9.8};
  a.counter = 65535;
  const ahrs_sample_t message = OverTheWire(ToMessage(a, core::GpsTime::FromNs(99)));
  EXPECT_EQ(message.gps_ns, 99);
  const auto b = FromMessage(message);
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(b->counter, 65535);
  EXPECT_EQ(b->specific_force_mps2, a.specific_force_mps2);
  EXPECT_NEAR(b->attitude.pitch_rad, 0.2, kRad);
}

TEST(Convert, ClockOverAndBack) {
  estimation::ClockStatus a;
  a.mono = core::MonoTime::FromNs(1);
  a.stream = estimation::StreamTime::FromNs(2);
  a.source = estimation::ClockSource::kHoldover;
  a.steps = 3;
  const clock_t message = OverTheWire(ToMessage(a, "ahrs"));
  EXPECT_EQ(message.stream, "ahrs");
  const auto b = FromMessage(message);
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(b->source, a.source);
  EXPECT_EQ(b->stream, a.stream);
}

TEST(Convert, WhatCannotBeIsRefused) {
  const auto refused = [](auto change) {
    pose_t message = ToMessage(SomePose());
    change(message);
    return !FromMessage(message).has_value();
  };
  EXPECT_FALSE(refused([](pose_t&) {}));
  EXPECT_TRUE(refused([](pose_t& m) { m.rtk_state = 6; }));
  EXPECT_TRUE(refused([](pose_t& m) { m.rtk_state = -1; }));
  EXPECT_TRUE(refused([](pose_t& m) { m.lat_deg = 90.1; }));
  EXPECT_TRUE(refused([](pose_t& m) { m.lon_deg = kNaN; }));
  EXPECT_TRUE(refused([](pose_t& m) { m.yaw_deg = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](pose_t& m) { m.position_cov_enu_m2[4] = kNaN; }));
  EXPECT_FALSE(refused(
      [](pose_t& m) { m.valid = 0, m.lat_deg = kNaN; }));  // says itself that it is not known
}

}  // namespace
}  // namespace kawara::comms
