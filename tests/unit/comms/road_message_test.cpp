#include "comms/road_message.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "comms/codec.hpp"

namespace kawara::comms {
namespace {

core::RoadStation Station(double along, const std::string& road = "carriageway") {
  core::RoadStation s;
  s.road = road;
  s.along_m = along;
  s.left_m = {along, 3.2, 51.92};
  s.right_m = {along, -3.1, 51.88};
  s.road_width_m = 6.3;
  s.passable_m = 3.4125;
  s.passable_sd_m = 0.0625;
  s.gap_begin_m = 0.5;
  s.gap_end_m = 3.9125;
  s.unknown_share = 0.25;
  s.passable_class = 2;
  s.observed = core::UtcTime::FromNs(1'790'000'000'123'456'789);
  return s;
}

RoadReport Report(int stations) {
  RoadReport report{"rover", "20261123T100000Z", {0.617, 2.435, 52.0}, {}};
  for (int i = 0; i < stations; ++i) report.stations.push_back(Station(0.5 * i));
  return report;
}

TEST(RoadMessage, ManyStationsCrossInSmallMessagesAndComeBackAsTheyWere) {
  const RoadReport sent = Report(100);
  const auto messages = ToMessages(sent);
  ASSERT_TRUE(messages) << messages.error().message;
  EXPECT_LE(messages->size(), 20U);
  std::vector<core::RoadStation> back;
  for (const road_stations_t& message : *messages) {
    const auto bytes = Encode(message);
    ASSERT_TRUE(bytes);
    EXPECT_LE(bytes->size(), kMaxRoadBytes);
    const auto report = FromMessage(*Decode<road_stations_t>(*bytes));
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->robot, sent.robot);
    EXPECT_EQ(report->mission, sent.mission);
    EXPECT_NEAR(report->origin.lat_rad, sent.origin.lat_rad, 1e-15);
    back.insert(back.end(), report->stations.begin(), report->stations.end());
  }
  ASSERT_EQ(back.size(), sent.stations.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    const core::RoadStation &a = sent.stations[i], &b = back[i];
    EXPECT_EQ(a.road, b.road);
    EXPECT_EQ(a.left_m, b.left_m);
    EXPECT_EQ(a.right_m, b.right_m);
    EXPECT_EQ(a.passable_class, b.passable_class);
    EXPECT_EQ(a.observed, b.observed);
    for (const auto field : {&core::RoadStation::along_m, &core::RoadStation::road_width_m,
                             &core::RoadStation::passable_m, &core::RoadStation::passable_sd_m,
                             &core::RoadStation::gap_begin_m, &core::RoadStation::gap_end_m,
                             &core::RoadStation::unknown_share})
      EXPECT_NEAR(a.*field, b.*field, 1e-5);
  }
}

TEST(RoadMessage, OneRoadAMessage) {
  RoadReport report = Report(2);
  report.stations[1].road = "lane";
  const auto messages = ToMessages(report);
  ASSERT_TRUE(messages);
  ASSERT_EQ(messages->size(), 2U);
  EXPECT_EQ((*messages)[1].road, "lane");
}

TEST(RoadMessage, WhatDoesNotFitIsRefused) {
  RoadReport report = Report(1);
  report.stations[0].road = std::string(900, 'x');
  const auto messages = ToMessages(report);
  ASSERT_FALSE(messages);
  EXPECT_EQ(messages.error().code, core::ErrorCode::kInvalidArgument);
}

TEST(RoadMessage, HostileOnesAreRefused) {
  const auto refused = [](const auto& spoil) {
    road_stations_t m = ToMessages(Report(2))->front();
    spoil(m);
    const auto back = FromMessage(m);
    return !back && back.error().code == core::ErrorCode::kFormat;
  };
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(refused([](road_stations_t&) {}));
  EXPECT_TRUE(refused([](road_stations_t& m) { m.origin_lat_deg = 91.0; }));
  EXPECT_TRUE(refused([](road_stations_t& m) { m.origin_h_m = std::nan(""); }));
  EXPECT_TRUE(refused([](road_stations_t& m) { m.left_enu_m[1][2] = std::nan(""); }));
  EXPECT_TRUE(refused([](road_stations_t& m) { m.along_m[0] = -1.0F; }));
  EXPECT_TRUE(refused([=](road_stations_t& m) { m.passable_m[1] = kNaN; }));
  EXPECT_TRUE(refused([](road_stations_t& m) { m.unknown_share[0] = 1.5F; }));
}

}  // namespace
}  // namespace kawara::comms
