#include "drivers/nmea.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/gnss_recording.hpp"

namespace kawara::drivers {
namespace {

/// Parses "GPGGA,..." as the stream would.
NmeaBody Parse(const std::string& body) {
  const testing::Bytes bytes = testing::ToBytes(testing::Sentence(body));
  const NmeaProbeResult probe = NmeaProbe(bytes);
  EXPECT_EQ(probe.match, NmeaMatch::kSentence) << body;
  return ParseNmea(probe.sentence);
}

template <class T>
T ParseAs(const std::string& body) {
  const NmeaBody parsed = Parse(body);
  const T* contents = std::get_if<T>(&parsed);
  EXPECT_NE(contents, nullptr) << body;
  return contents == nullptr ? T{} : *contents;
}

bool IsInvalid(const std::string& body) { return std::holds_alternative<NmeaInvalid>(Parse(body)); }

TEST(Gga, Trimble) {
  const auto m = ParseAs<NmeaGga>(
      "GNGGA,132819.60,4134.49795459,N,09345.03431408,W,2,10,0.9,278.161,M,-31.442,M,6.6,0133");
  EXPECT_EQ(m.time_utc->count(), 48'499'600'000'000);
  EXPECT_NEAR(m.lat_deg, 41.574965910, 5e-10);  // as gpsd prints it
  EXPECT_NEAR(m.lon_deg, -93.750571901, 5e-10);
  EXPECT_EQ(m.quality, 2);
  EXPECT_EQ(m.satellites, 10);
  EXPECT_DOUBLE_EQ(m.hdop, 0.9);
  EXPECT_DOUBLE_EQ(m.altitude_m, 278.161);
  EXPECT_DOUBLE_EQ(m.geoid_separation_m, -31.442);
  EXPECT_DOUBLE_EQ(m.age_s, 6.6);
  EXPECT_EQ(m.station, 133);
}

TEST(Gga, WithoutFixIsValidAndEmpty) {
  const auto m = ParseAs<NmeaGga>("GPGGA,,,,,,0,00,99.99,,,,,,");
  EXPECT_FALSE(m.has_position);
  EXPECT_FALSE(m.time_utc);
  EXPECT_EQ(m.quality, 0);
  EXPECT_TRUE(std::isnan(m.altitude_m));
  EXPECT_EQ(m.station, kNoInteger);
}

TEST(Gga, StationMayBeAName) {
  EXPECT_EQ(ParseAs<NmeaGga>("GPGGA,123400.0,,,,,0,,,,,,,,TSTR").station, kNoInteger);
}

TEST(Rmc, UbloxNavigationStatusVIsNormal) {
  const auto m =
      ParseAs<NmeaRmc>("GNRMC,092542.00,A,4846.4008666,N,00854.7249096,E,0.011,,200420,,,R,V");
  EXPECT_TRUE(m.valid);
  EXPECT_EQ(m.mode, 'R');
  EXPECT_EQ(m.nav_status, 'V');
  EXPECT_EQ(m.year, 2020);
  EXPECT_EQ(m.month, 4);
  EXPECT_EQ(m.day, 20);
  EXPECT_NEAR(m.speed_mps, 0.011 * 1852.0 / 3600.0, 1e-12);
  EXPECT_TRUE(std::isnan(m.course_deg));
}

TEST(Rmc, VersionsFrom2To4) {
  const std::string common = "GPRMC,183530.00,A,2037.7601,N,08704.0737,W,00.0,359.4,231207,01,W";
  EXPECT_EQ(ParseAs<NmeaRmc>(common).mode, '\0');
  EXPECT_EQ(ParseAs<NmeaRmc>(common + ",A").mode, 'A');
  EXPECT_EQ(ParseAs<NmeaRmc>(common + ",A,S").nav_status, 'S');
  EXPECT_EQ(ParseAs<NmeaRmc>(common).magnetic_variation_deg, -1.0);
}

TEST(Rmc, YearsOfTwoDigits) {
  const auto year = [](const std::string& date) {
    return ParseAs<NmeaRmc>("GPRMC,120000,V,,,,,,," + date + ",,").year;
  };
  EXPECT_EQ(year("060180"), 1980);
  EXPECT_EQ(year("311299"), 1999);
  EXPECT_EQ(year("010100"), 2000);
  EXPECT_EQ(year("311279"), 2079);
}

TEST(Vtg, TakesTheFinerSpeed) {
  EXPECT_NEAR(ParseAs<NmeaVtg>("GPVTG,54.7,T,34.4,M,5.5,N,10.186,K,A").speed_mps, 10.186 / 3.6,
              1e-12);
  EXPECT_NEAR(ParseAs<NmeaVtg>("GPVTG,54.7,T,34.4,M,005.500,N,010.2,K").speed_mps,
              5.5 * 1852 / 3600, 1e-12);
  EXPECT_NEAR(ParseAs<NmeaVtg>("GPVTG,54.7,34.4,5.5,10.2").speed_mps, 5.5 * 1852 / 3600, 0.03);
  EXPECT_TRUE(std::isnan(ParseAs<NmeaVtg>("GPVTG,,T,,M,,N,,K,N").speed_mps));
}

TEST(Gst, SixSigmas) {
  const auto m = ParseAs<NmeaGst>("GNGST,172814.0,0.006,0.023,0.020,273.6,0.023,0.020,0.031");
  EXPECT_DOUBLE_EQ(m.semi_major_m, 0.023);
  EXPECT_DOUBLE_EQ(m.orientation_deg, 273.6);
  EXPECT_DOUBLE_EQ(m.lat_sd_m, 0.023);
  EXPECT_DOUBLE_EQ(m.lon_sd_m, 0.020);
  EXPECT_DOUBLE_EQ(m.alt_sd_m, 0.031);
}

TEST(Gsa, WithAndWithoutSystem) {
  const auto old = ParseAs<NmeaGsa>("GPGSA,A,2,02,10,28,,,,,,,,,,02.2,02.2,");
  EXPECT_EQ(old.fix, 2);
  ASSERT_EQ(old.count, 3);
  EXPECT_EQ(old.satellites[2], 28);
  EXPECT_TRUE(std::isnan(old.vdop));
  EXPECT_EQ(old.system, kNoInteger);
  EXPECT_EQ(ParseAs<NmeaGsa>("GNGSA,A,3,65,67,80,,,,,,,,,,1.8,1.0,1.5,2").system, 2);
}

TEST(Gsv, ShortLastSentenceAndSignal) {
  const auto m = ParseAs<NmeaGsv>("GPGSV,3,3,10,33,08,096,,35,45,118,");
  EXPECT_EQ(m.total, 3);
  ASSERT_EQ(m.count, 2);
  EXPECT_EQ(m.satellites[0].elevation_deg, 8);
  EXPECT_EQ(m.satellites[0].azimuth_deg, 96);
  EXPECT_EQ(m.satellites[0].snr_dbhz, kNoInteger);
  EXPECT_EQ(ParseAs<NmeaGsv>("GBGSV,1,1,01,11,77,123,47,B").signal, 11);
  EXPECT_EQ(ParseAs<NmeaGsv>("GAGSV,1,1,00,7").signal, 7);
  EXPECT_EQ(ParseAs<NmeaGsv>("GAGSV,1,1,00").in_view, 0);
}

TEST(Zda, DateAndZone) {
  const auto m = ParseAs<NmeaZda>("GPZDA,183531.00,23,12,2007,00,00");
  EXPECT_TRUE(m.has_date);
  EXPECT_EQ(m.year, 2007);
  EXPECT_FALSE(ParseAs<NmeaZda>("GPZDA,,,,,,").has_date);
}

TEST(Heading, HdtAndThs) {
  EXPECT_DOUBLE_EQ(ParseAs<NmeaHeading>("GPHDT,123.456,T").true_heading_deg, 123.456);
  EXPECT_EQ(ParseAs<NmeaHeading>("GNTHS,77.52,E").mode, 'E');
  EXPECT_EQ(ParseAs<NmeaHeading>("GNTHS,,V").mode, 'V');
}

TEST(Gbs, OldAndNew) {
  const auto m = ParseAs<NmeaGbs>("GPGBS,110425.00,12.450,10.950,0.777,,,,");
  EXPECT_DOUBLE_EQ(m.lat_sd_m, 12.45);
  EXPECT_EQ(ParseAs<NmeaGbs>("GNGBS,170556.00,3.0,2.9,8.3,03,0.1,-21.4,3.8,1,0").failed_satellite,
            3);
}

TEST(ParseNmea, AnyTalkerAndUnknownTypes) {
  for (const char* talker : {"GP", "GN", "GL", "GA", "GB", "BD", "GQ", "QZ", "GI", "IN"})
    EXPECT_EQ(ParseAs<NmeaHeading>(std::string(talker) + "HDT,1.0,T").true_heading_deg, 1.0)
        << talker;
  EXPECT_TRUE(std::holds_alternative<NmeaOther>(Parse("GPGLL,4916.45,N,12311.12,W,225444,A")));
  EXPECT_TRUE(std::holds_alternative<NmeaOther>(Parse("PUBX,00,1")));
}

/// One damaged sentence in 256 has the right checksum: what can be told from its contents must be
/// told.
TEST(ParseNmea, WrongContentsWithTheRightChecksum) {
  const char* bodies[] = {
      // a field too few, too many
      "GPGGA,132819.60,4134.49,N,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6",
      "GPGGA,132819.60,4134.49,N,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6,0133,1",
      // time, latitude, minutes, hemisphere, quality, altitude, units, separation
      "GPGGA,252819.60,4134.49,N,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6,0133",
      "GPGGA,132819.60,9134.49,N,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6,0133",
      "GPGGA,132819.60,4174.49,N,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6,0133",
      "GPGGA,132819.60,4134.49,E,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6,0133",
      "GPGGA,132819.60,4134.49,N,09345.03,W,A,10,0.9,278.1,M,-31.4,M,6.6,0133",
      "GPGGA,132819.60,4134.49,N,09345.03,W,2,10,0.9,278100.0,M,-31.4,M,6.6,0133",
      "GPGGA,132819.60,4134.49,N,09345.03,W,2,10,0.9,278.1,F,-31.4,M,6.6,0133",
      "GPGGA,132819.60,4134.49,N,09345.03,W,2,10,0.9,278.1,M,-314.4,M,6.6,0133",
      "GPGGA,132819.60,4134.4l9,N,09345.03,W,2,10,0.9,278.1,M,-31.4,M,6.6,0133",
      // a fix without a position
      "GPGGA,132819.60,,,,,2,10,0.9,278.1,M,-31.4,M,6.6,0133",
      "GPRMC,132819.60,A,,,,,0.148,124.888,180320,11.5985,E,D",
      // dates that are none, a status that is none
      "GPRMC,132819.60,A,4134.49,N,09345.03,W,0.148,124.888,310220,11.5985,E,D",
      "GPRMC,132819.60,A,4134.49,N,09345.03,W,0.148,124.888,1803200,11.5985,E,D",
      "GPRMC,132819.60,B,4134.49,N,09345.03,W,0.148,124.888,180320,11.5985,E,D",
      "GPRMC,132819.60,A,4134.49,N,09345.03,W,0.148,524.888,180320,11.5985,E,D",
      "GPZDA,183531.00,31,11,2007,00,00",
      "GPZDA,183531.00,23,12,1907,00,00",
      // knots and km/h that do not belong together
      "GPVTG,54.7,T,34.4,M,5.5,N,18.2,K,A",
      "GPGST,172814.0,0.006,0.023,0.020,273.6,-0.023,0.020,0.031",
      "GPGSV,3,4,10,33,08,096,,35,45,118,",
      "GPGSV,3,3,10,33,08,396,,35,45,118,",
      "GPHDT,361.0,T",
      "GPHDT,36.0,M",
      "GPTHS,36.0,",
  };
  for (const char* body : bodies) EXPECT_TRUE(IsInvalid(body)) << body;
}

}  // namespace
}  // namespace kawara::drivers
