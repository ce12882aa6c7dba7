#include "drivers/text_fields.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace kawara::drivers {
namespace {

TEST(ParseDecimal, KeepsEveryDigit) {
  struct Case {
    const char* text;
    std::int64_t mantissa;
    int decimals;
  };
  const Case cases[] = {{"0", 0, 0},
                        {"-0.5", -5, 1},
                        {"+00012.384", 12384, 3},
                        {".25", 25, 2},
                        {"7.", 7, 0},
                        {"4134.49795459", 413449795459, 8},
                        {"0.123456789012345678", 123456789012345678, 18},
                        // Digits after the eighteenth are dropped, not wrapped round.
                        {"0.12345678901234567899", 123456789012345678, 18}};
  for (const Case& c : cases) {
    Decimal d;
    ASSERT_TRUE(ParseDecimal(c.text, d)) << c.text;
    EXPECT_EQ(d.mantissa, c.mantissa) << c.text;
    EXPECT_EQ(d.decimals, c.decimals) << c.text;
  }
}

TEST(ParseDecimal, RefusesWhatIsNoNumber) {
  for (const char* text : {"", "-", ".", "+.", "1.2.3", "1e5", "0x10", "12 ", " 12", "1,5", "nan",
                           "--1", "1-", "99999999999999999999"}) {
    Decimal d;
    EXPECT_FALSE(ParseDecimal(text, d)) << text;
  }
}

TEST(ParseDecimal, IsTheNearestDouble) {
  for (const char* text : {"0.1", "41.57496590983", "278.161", "999999.999999", "-31.442"}) {
    Decimal d;
    ASSERT_TRUE(ParseDecimal(text, d));
    EXPECT_EQ(d.value(), std::stod(text)) << text;
  }
}

TEST(FieldReader, PositionsKeepATenthOfAMillimetre) {
  // Neighbours that differ in the seventh decimal of a minute are 0.19 mm apart.
  double lat[2];
  double lon[2];
  FieldReader a("4846.4008666,N,00854.7249096,E");
  FieldReader b("4846.4008667,N,00854.7249097,E");
  ASSERT_TRUE(a.LatLon(lat[0], lon[0]));
  ASSERT_TRUE(b.LatLon(lat[1], lon[1]));
  constexpr double kDegree = 1e-7 / 60.0;
  EXPECT_NEAR(lat[1] - lat[0], kDegree, 1e-13);
  EXPECT_NEAR(lon[1] - lon[0], kDegree, 1e-13);
  EXPECT_NEAR(lat[0], 48.0 + 46.4008666 / 60.0, 1e-13);
}

TEST(FieldReader, PositionsThatCannotBe) {
  for (const char* text : {"9000.0001,N,00000.0,E", "4160.01,N,00000.0,E", "4134.5,N,18000.1,E",
                           "4134.5,X,00000.0,E", "4134.5,,00000.0,E", "-4134.5,N,00000.0,E",
                           "4134.5,N,,", "41x4.5,N,00000.0,E", "4134.5,N,00000.0,EE"}) {
    FieldReader f(text);
    double lat = 0.0;
    double lon = 0.0;
    EXPECT_FALSE(f.LatLon(lat, lon)) << text;
    EXPECT_FALSE(f.ok()) << text;
  }
}

TEST(FieldReader, PolesDateLineAndRoundedMinutes) {
  double lat = 0.0;
  double lon = 0.0;
  FieldReader limits("9000.0000,S,18000.000,W");
  ASSERT_TRUE(limits.LatLon(lat, lon));
  EXPECT_EQ(lat, -90.0);
  EXPECT_EQ(lon, -180.0);
  FieldReader rounded("4160.0000,N,00860.000,E");
  ASSERT_TRUE(rounded.LatLon(lat, lon));
  EXPECT_EQ(lat, 42.0);
  EXPECT_EQ(lon, 9.0);
}

TEST(FieldReader, TimesOfDay) {
  struct Case {
    const char* text;
    bool good;
    std::int64_t ns;
  };
  const Case cases[] = {{"132819.60", true, 48'499'600'000'000},
                        {"000000", true, 0},
                        {"235959.999999999", true, 86'399'999'999'999},
                        {"235960.5", true, 86'400'500'000'000},
                        {"120060.0", false, 0},
                        {"240000.00", false, 0},
                        {"126000.00", false, 0},
                        {"13281", false, 0},
                        {"1328x9.60", false, 0},
                        {"132819,60", true, 48'499'000'000'000},
                        {"132819.6x", false, 0},
                        {"-32819.60", false, 0}};
  for (const Case& c : cases) {
    FieldReader f(c.text);
    core::Duration time{};
    EXPECT_EQ(f.TimeOfDay(time), c.good) << c.text;
    EXPECT_EQ(f.ok(), c.good) << c.text;
    EXPECT_EQ(time.count(), c.ns) << c.text;
  }
}

TEST(FieldReader, EmptyIsNotSaidAndTheEndIsAnError) {
  FieldReader f(",,");
  EXPECT_EQ(f.count(), 3);
  EXPECT_TRUE(std::isnan(f.Number(0, 1)));
  EXPECT_EQ(f.Integer(0, 9, -1), -1);
  EXPECT_FALSE(f.done());
  EXPECT_EQ(f.Letter("MA"), '\0');
  EXPECT_TRUE(f.done());
  EXPECT_TRUE(f.ok());
  f.Text();
  EXPECT_FALSE(f.ok());
}

}  // namespace
}  // namespace kawara::drivers
