#include "drivers/gnss_epoch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/counting_allocator.hpp"
#include "tests/support/gnss_chain.hpp"

namespace kawara::drivers {
namespace {

using core::GnssFix;
using core::MonoTime;
using core::RtkState;
using testing::Chain;
using testing::FixesOf;
using testing::Gga;
using testing::Gst;
using testing::Hms;
using testing::kNoon;
using testing::Rmc;

TEST(GnssEpoch, TrimbleRecording) {
  const auto fixes = FixesOf("nmea-rtk.log");
  ASSERT_EQ(fixes.size(), 122U);
  int dgps = 0;
  int fixed = 0;
  for (const GnssFix& f : fixes) {
    dgps += f.rtk == RtkState::kCodeDifferential ? 1 : 0;
    fixed += f.rtk == RtkState::kFixed ? 1 : 0;
    EXPECT_TRUE(f.has_position && f.has_velocity);
  }
  EXPECT_EQ(dgps, 104);
  EXPECT_EQ(fixed, 18);
  int long_gaps = 0;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const double step = core::ToSeconds(fixes[i].time - fixes[i - 1].time);
    if (std::abs(step - 0.1) < 1e-9) continue;
    EXPECT_NEAR(step, 629.9, 1e-9);
    ++long_gaps;
  }
  EXPECT_EQ(long_gaps, 1);
  // As gpsd decoded the first epoch (nmea-rtk.log.chk).
  const GnssFix& first = fixes.front();
  EXPECT_EQ(first.time, core::ToGps(core::FromCivil({2020, 3, 18, 13, 28, 19, 600'000'000})));
  EXPECT_NEAR(first.antenna.lat_rad * core::kDegFromRad, 41.574965910, 5e-10);
  EXPECT_NEAR(first.antenna.lon_rad * core::kDegFromRad, -93.750571901, 5e-10);
  EXPECT_NEAR(first.antenna.h_ellipsoidal_m, 246.7190, 1e-9);
  EXPECT_EQ(first.base_station, 133);
  EXPECT_EQ(first.native_quality, 2);
  EXPECT_NEAR(first.correction_age_s, 6.6, 1e-12);
}

TEST(GnssEpoch, Ac12PairsZdaAheadAndPbnInGpsTime) {
  GnssEpochConfig config;
  config.profile = ReceiverProfile::kAshtech;
  const auto fixes = FixesOf("ac12_binary.log", config);
  ASSERT_EQ(fixes.size(), 5U);
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    EXPECT_EQ(fixes[i].time,
              core::ToGps(core::FromCivil({2007, 12, 23, 18, 35, 30 + static_cast<int>(i)})));
    EXPECT_NEAR(fixes[i].antenna.h_ellipsoidal_m, 58.48,
                0.03);  // POS, else altitude + separation of GGA
    EXPECT_EQ(fixes[i].rtk, RtkState::kAutonomous);
  }
  // Velocity of PBN, turned into east, north, up: a receiver at rest.
  EXPECT_LT(fixes[0].velocity_enu_mps.norm(), 0.01);
  EXPECT_GT(fixes[0].velocity_enu_mps.norm(), 0.001);
}

TEST(GnssEpoch, UbloxBinaryAsGpsdDecodesIt) {
  const auto fixes = FixesOf("ublox-zed-f9p-rtk.log");
  ASSERT_EQ(fixes.size(), 10U);
  const GnssFix& f = fixes[1];  // the first that the .chk has a position of
  EXPECT_EQ(f.time, core::ToGps(core::FromCivil({2022, 10, 11, 11, 4, 25})));
  EXPECT_NEAR(f.antenna.lat_rad * core::kDegFromRad, 47.129092700, 1e-10);
  EXPECT_NEAR(f.antenna.lon_rad * core::kDegFromRad, 15.212043200, 1e-10);
  EXPECT_NEAR(f.antenna.h_ellipsoidal_m, 869.218, 1e-9);
  EXPECT_EQ(f.rtk, RtkState::kFloat);
  EXPECT_TRUE(f.covariance_from_receiver);
  EXPECT_NEAR(std::sqrt(f.position_cov_enu_m2(0, 0) + f.position_cov_enu_m2(1, 1)), 0.337, 1e-9);
}

TEST(GnssEpoch, ComesWithItsLastSentenceOnceTheBurstIsKnown) {
  Chain chain;
  for (std::int64_t i = 0; i < 10; ++i) {
    const std::int64_t t = kNoon + i;
    chain.Feed(100 * i + 1, Gga(t));
    chain.Feed(100 * i + 5, Rmc(t));
    const std::size_t before_last = chain.fixes.size();
    chain.Feed(100 * i + 9, Gst(t));
    if (i < 3) continue;
    EXPECT_EQ(before_last, static_cast<std::size_t>(i));
    ASSERT_EQ(chain.fixes.size(), static_cast<std::size_t>(i) + 1);
    EXPECT_EQ(chain.fixes.back().arrival, MonoTime() + core::Milliseconds(100 * i + 1));
    EXPECT_TRUE(chain.fixes.back().covariance_from_receiver);
  }
  EXPECT_EQ(chain.assembler.stats().completed, 7U);
  EXPECT_EQ(chain.assembler.stats().late_sentences, 0U);
}

TEST(GnssEpoch, ALostSentenceIsNotWaitedForLongerThanTheTimeout) {
  Chain chain;
  for (std::int64_t i = 0; i < 5; ++i) {
    chain.Feed(1000 * i, Gga(kNoon + 10 * i));
    chain.Feed(1000 * i + 10, Rmc(kNoon + 10 * i));
  }
  chain.Feed(5000, Gga(kNoon + 50));
  chain.Tick(5100);
  EXPECT_EQ(chain.fixes.size(), 5U);
  chain.Tick(5260);
  ASSERT_EQ(chain.fixes.size(), 6U);
  EXPECT_EQ(chain.assembler.stats().timed_out, 1U);
  chain.Tick(5400);
  chain.Feed(6000, Gga(kNoon + 60));
  chain.Feed(6010, Rmc(kNoon + 60));
  EXPECT_EQ(chain.fixes.size(), 7U);
}

TEST(GnssEpoch, ASentenceThatComesSeldomIsNotWaitedFor) {
  Chain chain;
  for (std::int64_t i = 0; i < 40; ++i) {
    chain.Feed(100 * i, Gga(kNoon + i));
    chain.Feed(100 * i + 5, Rmc(kNoon + i));
    if (i >= 3) {
      EXPECT_EQ(chain.fixes.size(), static_cast<std::size_t>(i) + 1) << i;
    }
    if (i % 10 == 0) chain.Feed(100 * i + 9, Gst(kNoon + i));
  }
}

TEST(GnssEpoch, LearnsASentenceThatIsSwitchedOnLater) {
  Chain chain;
  for (std::int64_t i = 0; i < 20; ++i) {
    chain.Feed(100 * i, Gga(kNoon + i));
    chain.Feed(100 * i + 5, Rmc(kNoon + i));
    if (i >= 8) chain.Feed(100 * i + 9, Gst(kNoon + i));
  }
  EXPECT_TRUE(chain.fixes.back().covariance_from_receiver);
  EXPECT_EQ(chain.fixes.size(), 20U);
  EXPECT_EQ(chain.assembler.stats().late_sentences, 3U);
}

TEST(GnssEpoch, AHeadingBeforeItsEpochBelongsToThatEpoch) {
  Chain chain;
  for (std::int64_t i = 0; i < 12; ++i) {
    chain.Feed(1000 * i, "GPHDT," + std::to_string(i) + ".0,T");
    chain.Feed(1000 * i + 10, Gga(kNoon + 10 * i));
    chain.Feed(1000 * i + 20, Rmc(kNoon + 10 * i));
    if (i < 6) continue;
    ASSERT_EQ(chain.fixes.size(), static_cast<std::size_t>(i) + 1) << i;
    EXPECT_TRUE(chain.fixes.back().has_heading);
    EXPECT_NEAR(chain.fixes.back().heading_rad * core::kDegFromRad, static_cast<double>(i), 1e-9);
  }
}

TEST(GnssEpoch, AHeadingAfterItsEpochBelongsToThatEpoch) {
  Chain chain;
  for (std::int64_t i = 0; i < 12; ++i) {
    chain.Feed(1000 * i, Gga(kNoon + 10 * i));
    chain.Feed(1000 * i + 10, Rmc(kNoon + 10 * i));
    chain.Feed(1000 * i + 20, "GPTHS," + std::to_string(i) + ".0,A");
    if (i < 6) continue;
    ASSERT_EQ(chain.fixes.size(), static_cast<std::size_t>(i) + 1);
    EXPECT_NEAR(chain.fixes.back().heading_rad * core::kDegFromRad, static_cast<double>(i), 1e-9);
  }
  chain.Feed(12'000, Gga(kNoon + 120));
  chain.Feed(12'010, Rmc(kNoon + 120));
  chain.Feed(12'020, "GPTHS,5.0,V");
  EXPECT_FALSE(chain.fixes.back().has_heading) << "mode V";
}

TEST(GnssEpoch, AnUntimedSentenceInTheMiddleOfABurstDatesNoOtherEpoch) {
  Chain chain;
  for (std::int64_t i = 0; i < 12; ++i) {
    // The VTG comes closer to the GST after it than to the RMC before it, as at 115200 baud.
    chain.Feed(1000 * i, Gga(kNoon + 10 * i));
    chain.Feed(1000 * i + 8, Rmc(kNoon + 10 * i));
    chain.Feed(1000 * i + 16, "GPVTG,90.0,T,,M,2.00,N,3.70,K,A");
    chain.Feed(1000 * i + 20, Gst(kNoon + 10 * i));
  }
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(chain.fixes[i].arrival.ns(),
              core::Milliseconds(1000 * static_cast<std::int64_t>(i)).count());
  }
}

TEST(GnssEpoch, AReceiverWithoutFixIsAliveWithoutPosition) {
  Chain chain;
  for (std::int64_t i = 0; i < 4; ++i) {
    chain.Feed(1000 * i, "GPGGA," + Hms(kNoon + 10 * i) + ",,,,,0,00,99.9,,M,,M,,");
    chain.Feed(1000 * i + 5, "GPRMC," + Hms(kNoon + 10 * i) + ",V,,,,,,,200626,,,N");
  }
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 4U);
  EXPECT_FALSE(chain.fixes[0].has_position);
  EXPECT_FALSE(chain.fixes[0].has_velocity);
  EXPECT_EQ(chain.fixes[0].rtk, RtkState::kNone);
}

TEST(GnssEpoch, LegacyAshtechTakesTheStateFromPos) {
  GnssEpochConfig config;
  config.profile = ReceiverProfile::kAshtechLegacy;
  Chain chain(config);
  // GGA 2 may be float or code differential: POS knows.
  for (std::int64_t i = 0; i < 4; ++i) {
    chain.Feed(1000 * i, "GPGGA," + Hms(kNoon + 10 * i) +
                             ",3510.0,N,13658.0,E,2,09,0.9,+00087.500,M,,M,03.045,0001");
    chain.Feed(
        1000 * i + 5,
        "PASHR,POS,2,09," + Hms(kNoon + 10 * i) +
            ",3510.0000000,N,13658.0000000,E,+00087.500,,090.0,010.0,+005.0,1.6,0.9,1.3,1.0,UC00");
    chain.Feed(1000 * i + 8, Rmc(kNoon + 10 * i));
    chain.Feed(1000 * i + 9, "PASHR,LTN,48");
  }
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 4U);
  const GnssFix& f = chain.fixes.back();
  EXPECT_EQ(f.rtk, RtkState::kFloat);
  EXPECT_EQ(f.native_quality, 2);
  EXPECT_DOUBLE_EQ(f.antenna.h_ellipsoidal_m, 87.5);
  EXPECT_NEAR(f.velocity_enu_mps.x(), 10.0 * 1852 / 3600, 1e-9);
  EXPECT_NEAR(f.velocity_enu_mps.z(), 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(f.correction_age_s, 3.0);
  EXPECT_DOUBLE_EQ(f.latency_s, 0.048);
}

TEST(GnssEpoch, NeverAllocates) {
  const testing::Bytes bytes = testing::LoadRecording("ac12_binary.log");
  struct Counter : GnssFixSink {
    void OnFix(const GnssFix&) override { ++fixes; }
    int fixes = 0;
  } counter;
  GnssStreamDecoder decoder;
  GnssEpochAssembler assembler({});
  auto pass_on = [&](const GnssMessage& m) { assembler.OnMessage(m, counter); };
  testing::Each sink(pass_on);
  const auto allocations = testing::CountAllocations([&] {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const MonoTime now = MonoTime::FromNs(1'000'000 * static_cast<std::int64_t>(i + 1));
      decoder.Feed(now, {&bytes[i], 1}, sink);
      assembler.Tick(now, counter);
    }
    decoder.Finish(sink);
    assembler.Finish(counter);
  });
  EXPECT_EQ(counter.fixes, 5);
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace kawara::drivers
