#include "drivers/rtcm3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "corrections_data.hpp"

namespace kawara::drivers {
namespace {

using testing::BitWriter;
using testing::Bytes;
using testing::ReadRecording;

constexpr double kEcefTolerance_m = 0.00005;  // half a step

template <class Use>
void ForMessages(const std::string& file, Use use) {
  const Bytes stream = ReadRecording(file);
  std::span<const std::uint8_t> rest(stream);
  Rtcm3Framer framer;
  while (const auto frame = framer.Next(rest)) use(DecodeRtcm3(Rtcm3Payload(*frame)));
}
std::map<int, int> CountTypes(const std::string& file) {
  std::map<int, int> types;
  ForMessages(file, [&](const Rtcm3Message& m) {
    ++types[m.type];
    EXPECT_FALSE(m.malformed) << file << " " << m.type;
  });
  return types;
}

TEST(DecodeRtcm3, ExamplesOfTheStandard) {
  int seen = 0;
  ForMessages("rtcm3.log", [&](const Rtcm3Message& m) {
    ++seen;
    if (m.type == 1005) {
      const auto& s = std::get<Rtcm3Station>(m.body);
      EXPECT_EQ(m.station, 2003);
      EXPECT_NEAR(s.ecef_m.x(), 1114104.5999, kEcefTolerance_m);
      EXPECT_NEAR(s.ecef_m.y(), -4850729.7108, kEcefTolerance_m);
      EXPECT_NEAR(s.ecef_m.z(), 3975521.4643, kEcefTolerance_m);
      EXPECT_TRUE(s.gps);
      EXPECT_FALSE(s.glonass || s.galileo || s.virtual_station || s.has_antenna_height);
    } else {
      ASSERT_EQ(m.type, 1029);
      const auto& t = std::get<Rtcm3Text>(m.body);
      EXPECT_EQ(m.station, 23);
      EXPECT_EQ(t.modified_julian_day, 132);
      EXPECT_EQ(t.second_of_day, 59100U);
      EXPECT_EQ(t.characters, 21);
      EXPECT_EQ(t.utf8, "UTF-8 проверка wörter");
    }
  });
  EXPECT_EQ(seen, 2);
}

TEST(DecodeRtcm3, TypesOfTheRecordings) {
  EXPECT_EQ(CountTypes("testglo.rtcm3"),
            (std::map<int, int>{{1004, 186}, {1005, 19}, {1012, 186}, {1019, 19}, {1020, 19}}));
  EXPECT_EQ(
      CountTypes("rtcm3-2.log"),
      (std::map<int, int>{{1004, 83}, {1006, 8}, {1008, 8}, {1012, 84}, {1013, 8}, {1033, 8}}));
  EXPECT_EQ(CountTypes("ntrip_encode_chunked.bin"), (std::map<int, int>{{1006, 7},
                                                                        {1013, 1},
                                                                        {1019, 33},
                                                                        {1020, 33},
                                                                        {1033, 7},
                                                                        {1042, 33},
                                                                        {1046, 33},
                                                                        {1077, 33},
                                                                        {1087, 33},
                                                                        {1097, 33},
                                                                        {1127, 32},
                                                                        {1230, 7},
                                                                        {4094, 7}}));
}

TEST(DecodeRtcm3, BasePositionOfTestglo) {
  ForMessages("testglo.rtcm3", [&](const Rtcm3Message& m) {
    const auto* s = std::get_if<Rtcm3Station>(&m.body);
    if (s == nullptr) return;
    EXPECT_NEAR(s->ecef_m.x(), -3869297.5138, kEcefTolerance_m);
    EXPECT_NEAR(s->ecef_m.y(), 3436571.3345, kEcefTolerance_m);
    EXPECT_NEAR(s->ecef_m.z(), 3717369.3757, kEcefTolerance_m);
  });
}

TEST(DecodeRtcm3, Msm) {
  // Satellites 1, 5, 64; signals 2 and 15; cells 1/2, 1/15, 5/15, 64/2.
  const auto make = [](int type, unsigned satellite_bits, unsigned cell_bits) {
    BitWriter w;
    w.Put(type, 12).Put(99, 12).Put(345'600'250, 30).Put(1, 1).Put(0, 3 + 7 + 2 + 2 + 1 + 3);
    w.Put(static_cast<std::int64_t>((1ULL << 63) | (1ULL << 59) | 1ULL), 64);
    w.Put((1LL << 30) | (1LL << 17), 32).Put(0b11'01'10, 6);
    for (unsigned i = 0; i < 3 * satellite_bits + 4 * cell_bits; ++i) w.Put(1, 1);
    return w.bytes();
  };
  const std::array<std::array<unsigned, 2>, 7> sizes{
      {{10, 15}, {10, 27}, {10, 42}, {18, 48}, {36, 63}, {18, 65}, {36, 80}}};
  for (unsigned form = 1; form <= 7; ++form) {
    Bytes payload = make(1090 + static_cast<int>(form), sizes[form - 1][0], sizes[form - 1][1]);
    const Rtcm3Message m = DecodeRtcm3(payload);
    ASSERT_TRUE(std::holds_alternative<Rtcm3Observations>(m.body)) << form;
    const auto& o = std::get<Rtcm3Observations>(m.body);
    EXPECT_EQ(m.station, 99);
    EXPECT_EQ(o.system, GnssSystem::kGalileo);
    EXPECT_EQ(o.msm, form);
    EXPECT_EQ(o.time_sent, core::Milliseconds(345'600'250));
    EXPECT_TRUE(o.more_follow);
    EXPECT_EQ(o.satellites, 3);
    EXPECT_EQ(o.signals, 2);
    EXPECT_EQ(o.observations, 4);
    EXPECT_EQ(o.satellite_mask, (1ULL << 0) | (1ULL << 4) | (1ULL << 63));
    payload.pop_back();
    EXPECT_TRUE(DecodeRtcm3(payload).malformed) << form;
  }
}

TEST(DecodeRtcm3, MsmOfEveryConstellation) {
  const std::map<int, GnssSystem> first{{1071, GnssSystem::kGps},     {1081, GnssSystem::kGlonass},
                                        {1091, GnssSystem::kGalileo}, {1101, GnssSystem::kSbas},
                                        {1111, GnssSystem::kQzss},    {1121, GnssSystem::kBeidou},
                                        {1131, GnssSystem::kNavic}};
  for (const auto& [type, system] : first) {
    BitWriter w;  // no satellites: 169 bits of header, no cell mask
    w.Put(type, 12).Put(1, 12).Put(0, 30 + 1 + 18).Put(0, 64).Put(0, 32);
    const Rtcm3Message m = DecodeRtcm3(w.bytes());
    ASSERT_TRUE(std::holds_alternative<Rtcm3Observations>(m.body)) << type;
    EXPECT_EQ(std::get<Rtcm3Observations>(m.body).system, system) << type;
  }
  for (const int type : {1070, 1078, 1079, 1080, 1088, 1138}) {
    const Rtcm3Message m = DecodeRtcm3(BitWriter().Put(type, 12).Put(0, 400).bytes());
    EXPECT_TRUE(std::holds_alternative<std::monostate>(m.body)) << type;
    EXPECT_FALSE(m.malformed) << type;
  }
}

TEST(DecodeRtcm3, MsmWithTooManyCellsIsMalformed) {
  BitWriter w;
  w.Put(1077, 12).Put(1, 12).Put(0, 30 + 1 + 18).Put(-1, 64).Put(3, 32).Put(-1, 64).Put(-1, 64);
  for (int i = 0; i < 800; ++i) w.Put(0, 8);
  EXPECT_TRUE(DecodeRtcm3(w.bytes()).malformed);
}

TEST(DecodeRtcm3, GlonassMsmDay) {
  for (const int day : {0, 6, 7}) {
    BitWriter w;
    w.Put(1087, 12).Put(1, 12).Put(day, 3).Put(86'399'000, 27).Put(0, 1 + 18).Put(0, 64).Put(0, 32);
    const auto o = std::get<Rtcm3Observations>(DecodeRtcm3(w.bytes()).body);
    EXPECT_EQ(o.glonass_day_of_week, day == 7 ? -1 : day);
    EXPECT_EQ(o.time_sent, core::Milliseconds(86'399'000));
  }
}

TEST(DecodeRtcm3, LegacyFormsHaveTheirOwnLength) {
  struct Form {
    int type;
    unsigned header_rest, block;
  };
  // After type, station and time: flag 1, satellites 5, smoothing 4.
  for (const Form& f :
       {Form{1001, 30, 58}, Form{1002, 30, 74}, Form{1003, 30, 101}, Form{1004, 30, 125},
        Form{1009, 27, 64}, Form{1010, 27, 79}, Form{1011, 27, 107}, Form{1012, 27, 130}}) {
    for (unsigned satellites : {0U, 1U, 31U}) {
      BitWriter w;
      w.Put(f.type, 12).Put(7, 12).Put(1000, f.header_rest).Put(0, 1).Put(satellites, 5).Put(0, 4);
      for (unsigned i = 0; i < satellites; ++i) w.Put(i + 1, 6).Put(0, f.block - 6);
      Bytes payload = w.bytes();
      const Rtcm3Message m = DecodeRtcm3(payload);
      ASSERT_TRUE(std::holds_alternative<Rtcm3Observations>(m.body)) << f.type << " " << satellites;
      const auto& o = std::get<Rtcm3Observations>(m.body);
      EXPECT_EQ(o.satellites, satellites);
      EXPECT_EQ(o.observations, satellites * o.signals);
      EXPECT_EQ(o.satellite_mask, (1ULL << satellites) - 1);
      payload.pop_back();
      EXPECT_TRUE(DecodeRtcm3(payload).malformed) << f.type;
    }
  }
}

TEST(DecodeRtcm3, Descriptors) {
  BitWriter w;
  w.Put(1033, 12).Put(4095, 12).PutText("LEIAR25.R4      LEIT").Put(3, 8).PutText("725066");
  w.PutText("LEICA GR25").PutText("4.50").PutText("1830399");
  const Bytes payload = w.bytes();
  const Rtcm3Message m = DecodeRtcm3(payload);
  const auto& d = std::get<Rtcm3Descriptor>(m.body);
  EXPECT_EQ(m.station, 4095);
  EXPECT_EQ(d.antenna, "LEIAR25.R4      LEIT");
  EXPECT_EQ(d.antenna_setup, 3);
  EXPECT_EQ(d.antenna_serial, "725066");
  EXPECT_EQ(d.receiver, "LEICA GR25");
  EXPECT_EQ(d.receiver_firmware, "4.50");
  EXPECT_EQ(d.receiver_serial, "1830399");
  for (std::size_t n = 3; n < payload.size(); ++n) {
    EXPECT_TRUE(DecodeRtcm3(std::span<const std::uint8_t>(payload).first(n)).malformed) << n;
  }
}

TEST(DecodeRtcm3, GlonassBiases) {
  BitWriter w;
  w.Put(1230, 12).Put(5, 12).Put(1, 1).Put(0, 3).Put(0b1010, 4).Put(-100, 16).Put(250, 16);
  const auto b = std::get<Rtcm3GlonassBiases>(DecodeRtcm3(w.bytes()).body);
  EXPECT_TRUE(b.aligned);
  EXPECT_DOUBLE_EQ(b.bias_m[0], -2.0);
  EXPECT_TRUE(std::isnan(b.bias_m[1]));
  EXPECT_DOUBLE_EQ(b.bias_m[2], 5.0);
  EXPECT_TRUE(std::isnan(b.bias_m[3]));
}

TEST(DecodeRtcm3, UnknownTypesKeepTypeAndLength) {
  const Rtcm3Message m = DecodeRtcm3(BitWriter().Put(4072, 12).Put(0, 60).bytes());
  EXPECT_EQ(m.type, 4072);
  EXPECT_EQ(m.length, 9);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(m.body));
  EXPECT_FALSE(m.malformed);
}

TEST(DecodeRtcm3, EmptyAndOneByte) {
  EXPECT_EQ(DecodeRtcm3({}).type, 0);
  EXPECT_EQ(DecodeRtcm3(Bytes{0x3E}).type, 0);
}

TEST(DecodeRtcm3, NoTruncationReadsPastTheEnd) {
  // Exact heap blocks: the address sanitizer sees one byte too far.
  const Bytes stream = ReadRecording("ntrip_encode_chunked.bin");
  std::span<const std::uint8_t> rest(stream);
  Rtcm3Framer framer;
  std::map<int, bool> done;
  while (const auto frame = framer.Next(rest)) {
    const auto payload = Rtcm3Payload(*frame);
    if (done[DecodeRtcm3(payload).type]) continue;
    done[DecodeRtcm3(payload).type] = true;
    for (std::size_t n = 0; n < payload.size(); ++n) {
      const Bytes cut(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(n));
      const Rtcm3Message m = DecodeRtcm3(cut);
      EXPECT_TRUE(m.malformed || std::holds_alternative<std::monostate>(m.body))
          << m.type << " cut at " << n;
    }
  }
  EXPECT_GE(done.size(), 12U);
}

TEST(DecodeRtcm3, DoesNotAllocate) {
  const Bytes stream = ReadRecording("ntrip_encode_chunked.bin");
  std::span<const std::uint8_t> rest(stream);
  Rtcm3Framer framer;
  const auto before = testing::AllocationsOfThisThread();
  std::size_t observations = 0;
  while (const auto frame = framer.Next(rest)) {
    const Rtcm3Message m = DecodeRtcm3(Rtcm3Payload(*frame));
    if (const auto* o = std::get_if<Rtcm3Observations>(&m.body)) observations += o->observations;
  }
  EXPECT_EQ(testing::AllocationsOfThisThread(), before);
  EXPECT_GT(observations, 1000U);
}

core::GpsTime Gps(int year, int month, int day, int hour, int minute, int second) {
  core::CivilTime c{year, month, day, hour, minute, second, 0};
  return core::ToGps(core::FromCivil(c));
}

TEST(EpochOf, GpsWeekEnd) {
  Rtcm3Observations o;
  o.time_sent = core::Milliseconds(200);
  const core::GpsTime week = core::FromWeek({2300, core::Duration(0)});
  EXPECT_EQ(EpochOf(o, week - core::Seconds(3)), week + core::Milliseconds(200));
  o.time_sent = core::kGpsWeek - core::Milliseconds(200);
  EXPECT_EQ(EpochOf(o, week + core::Seconds(3)), week - core::Milliseconds(200));
  o.time_sent = core::kGpsWeek;
  EXPECT_FALSE(EpochOf(o, week));
}

TEST(EpochOf, BeidouIsFourteenSecondsBehind) {
  Rtcm3Observations o;
  o.system = GnssSystem::kBeidou;
  const core::GpsTime week = core::FromWeek({2300, core::Duration(0)});
  o.time_sent = core::Seconds(100);
  EXPECT_EQ(EpochOf(o, week), week + core::Seconds(114));
  o.time_sent = core::kGpsWeek - core::Seconds(4);  // still last week there
  EXPECT_EQ(EpochOf(o, week), week + core::Seconds(10));
}

TEST(EpochOf, GlonassDayBeginsAtNineInTheEveningUtc) {
  Rtcm3Observations o;
  o.system = GnssSystem::kGlonass;
  o.time_sent = core::Seconds(5);
  EXPECT_EQ(EpochOf(o, Gps(2024, 6, 1, 20, 59, 58)), Gps(2024, 6, 1, 21, 0, 5));
  o.time_sent = std::chrono::hours(3);
  EXPECT_EQ(EpochOf(o, Gps(2024, 5, 31, 23, 59, 50)), Gps(2024, 6, 1, 0, 0, 0));
  o.time_sent = std::chrono::hours(24);  // a leap second
  EXPECT_FALSE(EpochOf(o, Gps(2016, 12, 31, 23, 59, 59)));
}

TEST(EpochOf, AllConstellationsOfOneCaptureAgree) {
  // The capture holds whole epochs: GPS, GLONASS, Galileo and BeiDou of each on the same GPS
  // second.
  const core::GpsTime reference = Gps(2023, 10, 21, 12, 0, 0);
  std::map<std::int64_t, int> systems_at;
  std::optional<core::GpsTime> near;
  ForMessages("ntrip_encode_chunked.bin", [&](const Rtcm3Message& m) {
    const auto* o = std::get_if<Rtcm3Observations>(&m.body);
    if (o == nullptr) return;
    if (!near && o->system == GnssSystem::kGps) near = EpochOf(*o, reference);
    if (near) ++systems_at[EpochOf(*o, *near).value().ns()];
  });
  EXPECT_GE(systems_at.size(), 32U);
  int complete = 0;
  for (const auto& [ns, systems] : systems_at) complete += systems == 4 ? 1 : 0;
  EXPECT_GE(complete, 31);
}

}  // namespace
}  // namespace kawara::drivers
