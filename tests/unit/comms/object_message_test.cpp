#include "comms/object_message.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "comms/codec.hpp"

namespace kawara::comms {
namespace {

using ::testing::HasSubstr;

/// Every field set, every name as long as a store takes it.
ObjectReport Biggest() {
  ObjectReport r;
  r.robot = std::string(64, 'r');
  r.mission = std::string(64, 'm');
  r.origin = {0.6231, 2.4383, 61.25};
  core::ChangedObject& o = r.object;
  o.uid = std::string(64, 'u');
  o.revision = 1234567;
  o.state = core::ChangeState::kGone;
  o.box = {.centre_m = {31.25, -25.5, 1.62}, .size_m = {7.98, 2.21, 3.24}, .heading_rad = -0.7312};
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) o.covariance(i, j) = 0.01 / (1 + i + j) / 3.0;
  }
  o.side_seen = {true, false, true, false, true};
  o.second_heading_rad = 0.8396;
  o.existence_probability = 0.987654321;
  o.size_class = core::SizeClass::kPerson;
  o.class_probability = 0.83;
  o.voxels = 4294967295U;
  o.votes = 81234567890ULL;
  o.last_absent = core::UtcTime::FromNs(1'700'000'000'123'456'789);
  o.first_seen = core::UtcTime::FromNs(1'790'000'000'123'456'789);
  o.last_seen = core::UtcTime::FromNs(1'790'000'001'123'456'789);
  o.gone = core::UtcTime::FromNs(1'790'000'002'123'456'789);
  for (const char c : {'a', 'b', 'c', 'd', 'e'}) o.robots.emplace_back(64, c);
  return r;
}

ObjectReport OverTheWire(const ObjectReport& report) {
  const auto message = ToMessage(report);
  EXPECT_TRUE(message) << message.error().message;
  const auto decoded = Decode<changed_object_t>(*Encode(*message));
  EXPECT_TRUE(decoded);
  const auto back = FromMessage(*decoded);
  EXPECT_TRUE(back) << back.error().message;
  return *back;
}

TEST(ObjectMessage, TheBiggestCrossesInOnePacket) {
  const auto message = ToMessage(Biggest());
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_LE(Encode(*message)->size(), kMaxObjectBytes);
}

TEST(ObjectMessage, WhatDoesNotCrossIsRefused) {
  ObjectReport crowd = Biggest();
  for (int i = 0; i < 3; ++i) crowd.object.robots.emplace_back(64, 'x');
  const auto message = ToMessage(crowd);
  ASSERT_FALSE(message);
  EXPECT_EQ(message.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_THAT(message.error().message, HasSubstr("fewer robots"));
}

TEST(ObjectMessage, ComesBackAsItWas) {
  const ObjectReport a = Biggest(), b = OverTheWire(a);
  EXPECT_EQ(a.robot, b.robot);
  EXPECT_EQ(a.mission, b.mission);
  EXPECT_NEAR(a.origin.lat_rad, b.origin.lat_rad, 1e-15);
  EXPECT_NEAR(a.origin.lon_rad, b.origin.lon_rad, 1e-15);
  EXPECT_EQ(a.origin.h_ellipsoidal_m, b.origin.h_ellipsoidal_m);
  const core::ChangedObject &o = a.object, &p = b.object;
  EXPECT_EQ(o.uid, p.uid);
  EXPECT_EQ(o.revision, p.revision);
  EXPECT_EQ(o.state, p.state);
  EXPECT_EQ(o.box.centre_m, p.box.centre_m);
  EXPECT_EQ(o.box.size_m, p.box.size_m);
  EXPECT_NEAR(o.box.heading_rad, p.box.heading_rad, 1e-15);
  EXPECT_EQ(o.covariance, p.covariance);
  EXPECT_EQ(o.side_seen, p.side_seen);
  EXPECT_NEAR(*o.second_heading_rad, p.second_heading_rad.value(), 1e-15);
  EXPECT_EQ(o.existence_probability, p.existence_probability);
  EXPECT_EQ(o.size_class, p.size_class);
  EXPECT_EQ(o.class_probability, p.class_probability);
  EXPECT_EQ(o.voxels, p.voxels);
  EXPECT_EQ(o.votes, p.votes);
  EXPECT_EQ(o.last_absent, p.last_absent);
  EXPECT_EQ(o.first_seen, p.first_seen);
  EXPECT_EQ(o.last_seen, p.last_seen);
  EXPECT_EQ(o.gone, p.gone);
  EXPECT_EQ(o.robots, p.robots);
}

TEST(ObjectMessage, WhatIsNotSetStaysSo) {
  ObjectReport bare;
  bare.object.uid = "a";
  bare.object.revision = 1;
  const core::ChangedObject back = OverTheWire(bare).object;
  EXPECT_FALSE(back.second_heading_rad);
  EXPECT_FALSE(back.last_absent.IsSet());
  EXPECT_FALSE(back.gone.IsSet());
  EXPECT_TRUE(back.robots.empty());
}

TEST(ObjectMessage, RefusesWhatNoRobotSays) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto change) {
    changed_object_t m = *ToMessage(Biggest());
    change(m);
    return m;
  };
  const std::vector<std::pair<const char*, changed_object_t>> cases{
      {"origin", with([](auto& m) { m.origin_lat_deg = 91; })},
      {"origin", with([&](auto& m) { m.origin_h_m = nan; })},
      {"uid", with([](auto& m) { m.uid.clear(); })},
      {"revision", with([](auto& m) { m.revision = 0; })},
      {"state", with([](auto& m) { m.state = 5; })},
      {"state", with([](auto& m) { m.state = -1; })},
      {"class", with([](auto& m) { m.size_class = 5; })},
      {"sides", with([](auto& m) { m.sides_seen = 32; })},
      {"box", with([&](auto& m) { m.centre_enu_m[1] = nan; })},
      {"box", with([&](auto& m) { m.heading_deg = nan; })},
      {"covariance", with([&](auto& m) { m.covariance[27] = nan; })},
      {"probability", with([&](auto& m) { m.class_probability = nan; })},
      {"count", with([](auto& m) { m.voxels = 1LL << 32; })},
      {"count", with([](auto& m) { m.votes = -1; })}};
  for (const auto& [what, message] : cases) {
    const auto report = FromMessage(message);
    ASSERT_FALSE(report) << what;
    EXPECT_EQ(report.error().code, core::ErrorCode::kFormat);
    EXPECT_THAT(report.error().message, HasSubstr(what));
  }
}

}  // namespace
}  // namespace kawara::comms
