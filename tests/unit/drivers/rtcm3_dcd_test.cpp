// Every message of rtcm3-2.log against what another program (inspectrtcm) printed of it.
#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>

#include "corrections_data.hpp"
#include "drivers/rtcm3.hpp"

namespace kawara::drivers {
namespace {

struct Printed {
  int type = 0;
  int station = -1;
  double time_s = -1.0;
  int satellites = -1;
  bool more = false;
  std::uint64_t mask = 0;
  int observations = 0;
  Eigen::Vector3d ecef_m = Eigen::Vector3d::Zero();
  double height_m = 0.0;
  std::string antenna, antenna_serial, receiver;
  int mjd = 0, sod = 0, announced = 0, leap = 0;
};

std::string Quoted(const std::string& line, const std::string& after) {
  const auto begin = line.find(after + "='");
  if (begin == std::string::npos) return "";
  const auto text = begin + after.size() + 2;
  return line.substr(text, line.find('\'', text) - text);
}

std::vector<Printed> ReadDump() {
  const auto bytes = testing::ReadRecording("rtcm3-2.dcd");
  std::istringstream file(std::string(bytes.begin(), bytes.end()));
  std::vector<Printed> all;
  for (std::string line; std::getline(file, line);) {
    if (const auto at = line.find("Type ");
        line.starts_with("RTCM3 (") && at != std::string::npos) {
      all.emplace_back();
      all.back().type = std::stoi(line.substr(at + 5));
      continue;
    }
    if (all.empty()) continue;
    Printed& p = all.back();
    int satellite = 0;
    if (std::sscanf(line.c_str(), "  SV= %d", &satellite) == 1) {
      p.mask |= std::uint64_t{1} << (satellite - 1);
      const auto l2 = line.find("L2 (");
      p.observations += 1 + (line.find("r=-----", l2) == std::string::npos ? 1 : 0);
      continue;
    }
    char more[4] = "";
    if (p.type == 1013 && line.find("MJD=") == std::string::npos) continue;
    if (std::sscanf(line.c_str(), "  ID= %d, TOW=%lf, More Data=%3[YesNo], GPS-Sats=%d", &p.station,
                    &p.time_s, more, &p.satellites) == 4 ||
        std::sscanf(line.c_str(), "  ID= %d, Tk=%lf, More Data=%3[YesNo], GLONASS-Sats=%d",
                    &p.station, &p.time_s, more, &p.satellites) == 4) {
      p.more = more[0] == 'Y';
    } else if (p.type == 1006) {
      std::sscanf(line.c_str(), " ID= %d", &p.station);
      std::sscanf(line.substr(line.find("X=")).c_str(), "X=%lf, Y=%lf, Z=%lf", &p.ecef_m.x(),
                  &p.ecef_m.y(), &p.ecef_m.z());
      std::sscanf(line.substr(line.find("height=")).c_str(), "height=%lf", &p.height_m);
    } else if (p.type == 1013 && line.find("MJD=") != std::string::npos) {
      std::sscanf(line.c_str(), " ID= %d, MJD=%d, SOD=%d, Num= %d, Leap=%d", &p.station, &p.mjd,
                  &p.sod, &p.announced, &p.leap);
    } else if (p.type == 1008 || p.type == 1033) {
      std::sscanf(line.c_str(), " ID= %d", &p.station);
      if (line.find("Antenna=") != std::string::npos) {
        p.antenna = Quoted(line, "Antenna");
        p.antenna_serial = Quoted(line, "Serial");
      } else {
        p.receiver = Quoted(line, "Receiver Type");
      }
    }
  }
  return all;
}

TEST(Rtcm3AgainstAnotherDecoder, EveryMessage) {
  const auto expected = ReadDump();
  ASSERT_EQ(expected.size(), 199U);
  const auto stream = testing::ReadRecording("rtcm3-2.log");
  std::span<const std::uint8_t> rest(stream);
  Rtcm3Framer framer;
  std::size_t i = 0;
  while (const auto frame = framer.Next(rest)) {
    ASSERT_LT(i, expected.size());
    const Printed& p = expected[i++];
    const Rtcm3Message m = DecodeRtcm3(Rtcm3Payload(*frame));
    ASSERT_EQ(m.type, p.type) << "message " << i;
    EXPECT_EQ(m.station, p.station) << "message " << i;
    if (const auto* o = std::get_if<Rtcm3Observations>(&m.body)) {
      EXPECT_DOUBLE_EQ(core::ToSeconds(o->time_sent), p.time_s) << "message " << i;
      EXPECT_EQ(o->more_follow, p.more) << "message " << i;
      EXPECT_EQ(o->satellites, p.satellites) << "message " << i;
      EXPECT_EQ(o->satellite_mask, p.mask) << "message " << i;
      EXPECT_EQ(o->observations, p.observations) << "message " << i;
    } else if (const auto* s = std::get_if<Rtcm3Station>(&m.body)) {
      EXPECT_LT((s->ecef_m - p.ecef_m).norm(), 1e-4) << "message " << i;
      EXPECT_NEAR(s->antenna_height_m, p.height_m, 1e-5) << "message " << i;
    } else if (const auto* d = std::get_if<Rtcm3Descriptor>(&m.body)) {
      EXPECT_EQ(d->antenna, p.antenna) << "message " << i;
      EXPECT_EQ(d->antenna_serial, p.antenna_serial) << "message " << i;
      EXPECT_EQ(d->receiver, p.receiver) << "message " << i;
    } else if (const auto* x = std::get_if<Rtcm3SystemParameters>(&m.body)) {
      EXPECT_EQ(x->modified_julian_day, p.mjd) << "message " << i;
      EXPECT_EQ(x->second_of_day, static_cast<std::uint32_t>(p.sod)) << "message " << i;
      EXPECT_EQ(x->announced, p.announced) << "message " << i;
      EXPECT_EQ(x->leap_seconds, p.leap) << "message " << i;
      EXPECT_EQ(x->announcements[1].type, 1006) << "message " << i;
      EXPECT_TRUE(x->announcements[1].synchronous) << "message " << i;
      EXPECT_DOUBLE_EQ(x->announcements[1].interval_s, 10.0) << "message " << i;
    } else {
      ADD_FAILURE() << "message " << i << " of type " << m.type << " has no body";
    }
  }
  EXPECT_EQ(i, expected.size());
}

}  // namespace
}  // namespace kawara::drivers
