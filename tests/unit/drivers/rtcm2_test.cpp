#include "drivers/rtcm2.hpp"

#include <gtest/gtest.h>

#include "corrections_data.hpp"

namespace kawara::drivers {
namespace {

using testing::BitWriter;

/// A message of `type` with these bits, filled up to whole words.
Rtcm2Message Make(int type, const BitWriter& bits) {
  Rtcm2Message m;
  m.type = static_cast<std::uint8_t>(type);
  auto bytes = bits.bytes();
  while (bytes.size() % 3 != 0) bytes.push_back(0);
  m.data_words = static_cast<std::uint8_t>(bytes.size() / 3);
  for (std::size_t i = 0; i < m.data_words; ++i) {
    m.data[i] = (std::uint32_t{bytes[3 * i]} << 16) | (std::uint32_t{bytes[3 * i + 1]} << 8) |
                bytes[3 * i + 2];
  }
  DecodeRtcm2Body(m);
  return m;
}

TEST(DecodeRtcm2Body, CorrectionsOfOneToThreeSatellites) {
  for (const int type : {1, 9, 31, 34}) {
    for (unsigned satellites = 1; satellites <= 3; ++satellites) {
      BitWriter w;
      for (unsigned i = 0; i < satellites; ++i)
        w.Put(i == 0, 1).Put(2, 2).Put(31 + i, 5).Put(-5, 16).Put(-3, 8).Put(77, 8);
      const auto m = Make(type, w);
      const auto& c = std::get<Rtcm2Corrections>(m.body);
      ASSERT_EQ(c.count, satellites);
      EXPECT_EQ(c.glonass, type > 30);
      EXPECT_EQ(c.satellites[0].id, 31);
      EXPECT_EQ(c.satellites[0].udre, 2);
      EXPECT_DOUBLE_EQ(c.satellites[0].range_m, -5 * 0.32);
      EXPECT_DOUBLE_EQ(c.satellites[0].rate_mps, -3 * 0.032);
      EXPECT_EQ(c.satellites[0].issue, 77);
      if (satellites > 1) {
        EXPECT_EQ(c.satellites[1].id, 32) << "sent as 0";
        EXPECT_DOUBLE_EQ(c.satellites[1].range_m, -5 * 0.02);
        EXPECT_DOUBLE_EQ(c.satellites[1].rate_mps, -3 * 0.002);
      }
    }
  }
}

TEST(DecodeRtcm2Body, Observations) {
  for (const int type : {18, 19, 20, 21}) {
    BitWriter w;
    w.Put(2, 2).Put(0, 2).Put(599'999, 20);
    w.Put(1, 1).Put(0, 1).Put(0, 1).Put(7, 5).Put(0, 40);
    w.Put(1, 1).Put(0, 1).Put(1, 1).Put(0, 5).Put(0, 40);
    Rtcm2Message m = Make(type, w);
    m.time_of_hour = std::chrono::milliseconds(600);
    const auto& o = std::get<Rtcm2Observations>(m.body);
    EXPECT_EQ(o.band, 2);
    EXPECT_TRUE(o.more_follow);
    EXPECT_EQ(o.count, 2);
    EXPECT_EQ(o.gps_mask, 1U << 6);
    EXPECT_EQ(o.glonass_mask, 1U << 31);
    EXPECT_EQ(Rtcm2TimeOfHour(m), std::chrono::microseconds(1'199'999));
  }
}

TEST(DecodeRtcm2Body, StationPositions) {
  const auto phase_centre =
      Make(3, BitWriter().Put(-386929751, 32).Put(343657133, 32).Put(371736938, 32));
  const auto& p = std::get<Rtcm2Station>(phase_centre.body);
  EXPECT_NEAR(p.ecef_m.x(), -3869297.51, 1e-6);
  EXPECT_NEAR(p.ecef_m.z(), 3717369.38, 1e-6);
  EXPECT_FALSE(p.is_reference_point);

  BitWriter w;
  w.Put(-38692975138, 38)
      .Put(0, 2)
      .Put(34365713345, 38)
      .Put(0, 2)
      .Put(37173693757, 38)
      .Put(0, 1)
      .Put(1, 1);
  w.Put(12345, 18).Put(0, 6);
  const auto reference_point = Make(24, w);
  const auto& r = std::get<Rtcm2Station>(reference_point.body);
  EXPECT_TRUE(r.is_reference_point);
  EXPECT_NEAR(r.ecef_m.x(), -3869297.5138, 1e-6);
  EXPECT_NEAR(r.ecef_m.y(), 3436571.3345, 1e-6);
  EXPECT_NEAR(r.ecef_m.z(), 3717369.3757, 1e-6);
  EXPECT_TRUE(r.has_antenna_height);
  EXPECT_NEAR(r.antenna_height_m, 1.2345, 1e-9);
}

TEST(DecodeRtcm2Body, StationOffsetOfOneToThreeWords) {
  BitWriter w;
  w.Put(-128, 8).Put(127, 8).Put(1, 8);
  auto m = Make(22, w);
  EXPECT_DOUBLE_EQ(std::get<Rtcm2StationOffset>(m.body).l1_m.x(), -0.005);
  EXPECT_FALSE(std::get<Rtcm2StationOffset>(m.body).has_antenna_height);
  w.Put(0, 5).Put(0, 1).Put(25600, 18);
  m = Make(22, w);
  EXPECT_TRUE(std::get<Rtcm2StationOffset>(m.body).has_antenna_height);
  EXPECT_DOUBLE_EQ(std::get<Rtcm2StationOffset>(m.body).antenna_height_m, 1.0);
  w.Put(16, 8).Put(-16, 8).Put(0, 8);
  m = Make(22, w);
  const auto& o = std::get<Rtcm2StationOffset>(m.body);
  EXPECT_TRUE(o.has_l2);
  EXPECT_DOUBLE_EQ(o.l2_m.x(), 0.01);
  EXPECT_DOUBLE_EQ(o.l2_m.y(), -0.01);
}

TEST(DecodeRtcm2Body, Antenna) {
  BitWriter w;
  w.Put(0, 2).Put(1, 1).Put(5, 5);
  for (const char c : std::string("ASH70")) w.Put(c, 8);
  w.Put(2, 8).Put(0, 3).Put(3, 5);
  for (const char c : std::string("242")) w.Put(c, 8);
  const auto m = Make(23, w);
  const auto& a = std::get<Rtcm2Antenna>(m.body);
  EXPECT_EQ(a.descriptor(), "ASH70");
  EXPECT_EQ(a.setup, 2);
  EXPECT_EQ(a.serial(), "242");
}

TEST(DecodeRtcm2Body, TooShortIsMalformed) {
  EXPECT_TRUE(Make(3, BitWriter().Put(0, 72)).malformed);
  EXPECT_TRUE(Make(24, BitWriter().Put(0, 120)).malformed);
  EXPECT_TRUE(Make(22, BitWriter()).malformed);
  EXPECT_TRUE(Make(18, BitWriter()).malformed);
  EXPECT_TRUE(Make(18, BitWriter().Put(0, 48)).malformed) << "half a satellite";
  EXPECT_TRUE(Make(19, BitWriter().Put(0, 4).Put(600'000, 20)).malformed)
      << "microseconds beyond the 0.6 s";
  EXPECT_TRUE(Make(23, BitWriter().Put(31, 8).Put(0, 40)).malformed);
}

TEST(DecodeRtcm2Body, OtherTypesKeepTheirWords) {
  const auto m = Make(59, BitWriter().Put(0xABCDEF, 24));
  EXPECT_FALSE(m.malformed);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(m.body));
  EXPECT_EQ(m.data[0], 0xABCDEFU);
}

}  // namespace
}  // namespace kawara::drivers
