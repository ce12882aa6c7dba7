#include "drivers/ashtech.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/ashtech_binary.hpp"
#include "drivers/receiver_profile.hpp"
#include "tests/support/gnss_recording.hpp"

namespace kawara::drivers {
namespace {

AshtechBody Parse(const std::string& body) {
  const testing::Bytes bytes = testing::ToBytes(testing::Sentence(body));
  return ParseAshtech(NmeaProbe(bytes).sentence);
}

template <class T>
T ParseAs(const std::string& body) {
  const AshtechBody parsed = Parse(body);
  const T* contents = std::get_if<T>(&parsed);
  EXPECT_NE(contents, nullptr) << body;
  return contents == nullptr ? T{} : *contents;
}

bool IsInvalid(const std::string& body) {
  return std::holds_alternative<AshtechInvalid>(Parse(body));
}

TEST(AshtechPos, RecordedAc12) {
  const auto m = ParseAs<AshtechPos>(
      "PASHR,POS,0,03,183530.00,2037.76012,N,08704.07373,W,058.48,,359.4,000.0,+000.0,2.2,2.2,0.0,"
      "1.0,BQ00");
  EXPECT_EQ(m.type, 0);
  EXPECT_EQ(m.satellites, 3);
  EXPECT_NEAR(m.lat_deg, 20.0 + 37.76012 / 60.0, 1e-13);
  EXPECT_DOUBLE_EQ(m.height_m, 58.48);
  EXPECT_DOUBLE_EQ(m.course_deg, 359.4);
  EXPECT_DOUBLE_EQ(m.tdop, 1.0);
  EXPECT_EQ(m.tail.view(), "BQ00");
}

TEST(AshtechPos, WithoutSolution) {
  const auto m = ParseAs<AshtechPos>("PASHR,POS,,02,183530.00,,,,,,,,,,,,,,SIM0");
  EXPECT_EQ(m.type, -1);
  EXPECT_FALSE(m.has_position);
  EXPECT_EQ(RtkStateOfPos(m.type), core::RtkState::kNone);
}

TEST(AshtechPos, UnitsDependOnTheModel) {
  AshtechPos pos;
  pos.speed_as_sent = 10.0;
  pos.vertical_as_sent = -5.0;
  const PosVelocity legacy = VelocityOfPos(pos, ReceiverProfile::kAshtechLegacy);
  EXPECT_NEAR(legacy.speed_mps, 5.1444, 1e-4);
  EXPECT_NEAR(legacy.up_mps, -0.5, 1e-12);
  EXPECT_NEAR(VelocityOfPos(pos, ReceiverProfile::kAshtech).up_mps, -5.0, 1e-12);
}

// The manual's example (Z-Family p.72), with its checksum made right.
TEST(AshtechCbn, ManualExample) {
  const auto m = ParseAs<AshtechCbn>(
      "PASHR,CBN,212501.00,????,08,001.2,3722.3784261,N,12159.8417992,W,-00005.0847,00.011,00.011,"
      "00.012,-00.000,+00.000,-00.000,221001,+000.000,-000.001,+000.001,00.000,00.000,00.000");
  EXPECT_EQ(m.time_utc->count(), 77'101'000'000'000);
  EXPECT_DOUBLE_EQ(m.h_ellipsoidal_m, -5.0847);
  EXPECT_DOUBLE_EQ(m.lat_sd_m, 0.011);
  EXPECT_DOUBLE_EQ(m.height_sd_m, 0.012);
  EXPECT_DOUBLE_EQ(m.north_mps, -0.001);
  EXPECT_EQ(RtkStateOfCbn(m), core::RtkState::kFixed);
}

TEST(AshtechCbn, FlagsTellTheSolution) {
  using core::RtkState;
  const auto state = [](std::array<std::uint8_t, 6> flags) {
    AshtechCbn cbn;
    cbn.flags = flags;
    return RtkStateOfCbn(cbn);
  };
  EXPECT_EQ(state({0, 2, 1, 0, 0, 0}), RtkState::kNone);
  EXPECT_EQ(state({2, 0, 0, 0, 0, 0}), RtkState::kAutonomous);
  EXPECT_EQ(state({1, 1, 0, 0, 0, 0}), RtkState::kCodeDifferential);
  EXPECT_EQ(state({2, 2, 0, 1, 0, 1}), RtkState::kFloat);
  EXPECT_EQ(state({2, 2, 1, 1, 0, 1}), RtkState::kFixed);
}

TEST(AshtechTimeTag, DaysCountFromSundayOnTheGpsScale) {
  // Good line of the manual: Wednesday (4), 03:32:45.0111305.
  const auto event = ParseAs<AshtechTimeTag>("PASHR,TTT,4,03:32:45.0111305");
  EXPECT_TRUE(event.is_event);
  EXPECT_EQ(event.time_of_week, 3 * core::kDay + core::Nanoseconds(12'765'011'130'500));
  const auto pulse = ParseAs<AshtechTimeTag>("PASHR,PTT,1,00:00:00.0000000");
  EXPECT_FALSE(pulse.is_event);
  EXPECT_EQ(pulse.time_of_week.count(), 0);
  for (const char* wrong :
       {"PASHR,TTT,0,03:32:45.0", "PASHR,TTT,8,03:32:45.0", "PASHR,TTT,4,03:32:61.0",
        "PASHR,TTT,4,23:59:60.0", "PASHR,TTT,4,033245.0", "PASHR,TTT,4,"})
    EXPECT_TRUE(IsInvalid(wrong)) << wrong;
}

TEST(AshtechSatellites, AzimuthComesBeforeElevation) {
  const auto m =
      ParseAs<AshtechSatellites>("PASHR,SAT,03,28,139,38,46,U,10,193,17,50,U,02,274,55,50,-");
  ASSERT_EQ(m.count, 3);
  // GSV of the same epoch says 28: elevation 38, azimuth 139.
  EXPECT_EQ(m.satellites[0].azimuth_deg, 139);
  EXPECT_EQ(m.satellites[0].elevation_deg, 38);
  EXPECT_TRUE(m.satellites[1].used);
  EXPECT_FALSE(m.satellites[2].used);
  EXPECT_TRUE(IsInvalid("PASHR,SAT,04,28,139,38,46,U,10,193,17,50,U,02,274,55,50,-"));
}

TEST(AshtechResiduals, BothNames) {
  const auto m = ParseAs<AshtechResiduals>("GPRRE,04,23,8.4,28,-9.2,11,-2.2,17,3.2,34.4,49.7");
  ASSERT_EQ(m.count, 4);
  EXPECT_DOUBLE_EQ(m.satellites[1].residual_m, -9.2);
  EXPECT_DOUBLE_EQ(m.vertical_rms_m, 49.7);
  EXPECT_EQ(ParseAs<AshtechResiduals>("PASHR,RRE,01,23,8.4,34.4,49.7").count, 1);
}

TEST(Ashtech, DialogueReplies) {
  EXPECT_TRUE(ParseAs<AshtechAck>("PASHR,ACK").accepted);
  EXPECT_FALSE(ParseAs<AshtechAck>("PASHR,NAK").accepted);
  const auto rid = ParseAs<AshtechIdentity>("PASHR,RID,UZ,30,UC00,-UE-MF-3J-,0A13");
  EXPECT_EQ(rid.model.view(), "UZ");
  EXPECT_EQ(rid.nav_firmware.view(), "UC00");
  EXPECT_EQ(rid.text.view(), "UZ,30,UC00,-UE-MF-3J-,0A13");
  const auto port = ParseAs<AshtechPort>("PASHR,PRT,B,9");
  EXPECT_EQ(port.port, 'B');
  EXPECT_EQ(port.baud_bps, 115200);
  const auto pps = ParseAs<AshtechPps>("PASHR,PPS,1,500,R");
  EXPECT_EQ(pps.period_s, 1.0);
  EXPECT_EQ(pps.offset_ms, 500.0);
  EXPECT_EQ(ParseAs<AshtechEventEdge>("PASHR,PHE,R").edge, 'R');
  EXPECT_DOUBLE_EQ(ParseAs<AshtechLatency>("PASHR,LTN,29").latency_s, 0.029);
  EXPECT_TRUE(std::holds_alternative<AshtechOther>(Parse("PASHR,XYZ,1")));
  for (const char* wrong : {"PASHR,PHE,X", "PASHR,PRT,,5", "PASHR,LTN,", "PASHR,LTN,abc"})
    EXPECT_TRUE(IsInvalid(wrong)) << wrong;
}

TEST(Ashtech, BaudCodes) {
  for (int code = 0; code < 10; ++code) EXPECT_EQ(AshtechBaudCode(AshtechBaud(code)), code);
  EXPECT_EQ(AshtechBaud(7), 38400);
  EXPECT_EQ(AshtechBaud(10), 0);
  EXPECT_EQ(AshtechBaudCode(14400), -1);
}

// Against values unpacked from the same bytes by an independent script (ac12_binary.pbn.json).
TEST(AshtechPbn, RecordedAc12) {
  std::vector<AshtechPbn> records;
  testing::DecodeEach(testing::LoadRecording("ac12_binary.log"), [&](const GnssMessage& m) {
    if (const auto* pbn = m.As<AshtechPbn>()) records.push_back(*pbn);
  });
  ASSERT_EQ(records.size(), 4U);
  EXPECT_EQ(records[0].time_of_week, core::Milliseconds(66'944'000));
  EXPECT_EQ(records[2].time_of_week, core::Milliseconds(66'946'000));
  EXPECT_DOUBLE_EQ(records[0].ecef_m.x(), 305467.78051815333);
  EXPECT_DOUBLE_EQ(records[0].ecef_m.y(), -5963884.747265178);
  EXPECT_DOUBLE_EQ(records[0].ecef_m.z(), 2233056.051490119);
  EXPECT_NEAR(records[1].velocity_ecef_mps.x(), 0.007259163074195385, 1e-15);
  EXPECT_NEAR(records[0].pdop, 2.19, 1e-12);
  EXPECT_TRUE(records[0].plausible);
}

TEST(AshtechBinaryProbe, TextOfTheSameTypeIsText) {
  const std::string text = testing::Sentence(
      "PASHR,PBN,129482.00,-2687893.9,-4301396.5,3854511.7,37:25.1,-121:58.2,15.1,0.1,0.2");
  EXPECT_EQ(AshtechBinaryProbe(testing::ToBytes(text)).match, AshtechBinaryMatch::kNoMatch);
  const testing::Bytes other = testing::ToBytes("$PASHR,ACK*3D\r\n");
  EXPECT_EQ(AshtechBinaryProbe(other).match, AshtechBinaryMatch::kNoMatch);
}

}  // namespace
}  // namespace kawara::drivers
