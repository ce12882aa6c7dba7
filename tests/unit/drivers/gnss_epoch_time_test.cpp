#include <gtest/gtest.h>

#include "drivers/gnss_epoch.hpp"
#include "tests/support/gnss_chain.hpp"

namespace kawara::drivers {
namespace {

using core::RtkState;
using testing::Chain;
using testing::FixesOf;
using testing::Gga;
using testing::kNoon;
using testing::Rmc;
using testing::Utc;

TEST(GnssEpochTime, BaselineOverMidnight) {
  const auto fixes = FixesOf("rtk_0759-3040_l1_ratio20.nmea");
  ASSERT_EQ(fixes.size(), 115U);
  EXPECT_EQ(fixes[0].time, core::ToGps(core::FromCivil({2005, 4, 1, 23, 59, 47})));
  EXPECT_EQ(fixes[1].time, core::ToGps(core::FromCivil({2005, 4, 2, 0, 0, 17})));
  for (std::size_t i = 0; i < fixes.size(); ++i)
    EXPECT_EQ(fixes[i].rtk, i < 7 ? RtkState::kFloat : RtkState::kFixed) << i;
}

TEST(GnssEpochTime, TheDateIsCarriedOverMidnightWithoutRmc) {
  GnssEpochConfig config;
  config.reference = core::FromCivil({2026, 6, 20, 20, 0, 0});
  Chain chain(config);
  constexpr std::int64_t kDay = 24 * 36000;
  for (std::int64_t i = -5; i < 5; ++i) chain.Feed(0, Gga((kDay + i) % kDay));
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 10U);
  EXPECT_EQ(chain.fixes[4].time, Utc(6, 20, 23, 59, 59, 900));
  EXPECT_EQ(chain.fixes[5].time, Utc(6, 21, 0, 0, 0));
}

TEST(GnssEpochTime, TheDateIsCarriedOverALongSilenceByTheArrivalStamps) {
  Chain chain;
  chain.Feed(0, Rmc(kNoon));
  chain.Feed(1000, Rmc(kNoon + 10));
  chain.Feed(1001, Gga(kNoon + 10));
  constexpr std::int64_t kThirtyHours = 30 * 3600;
  chain.Feed(1000 * kThirtyHours, Gga((kNoon + kThirtyHours * 10) % (24 * 36000)));
  chain.Finish();
  EXPECT_EQ(chain.fixes.back().time, Utc(6, 21, 18, 0, 0));
}

TEST(GnssEpochTime, NoDateNoFix) {
  Chain chain;
  for (std::int64_t i = 0; i < 5; ++i) chain.Feed(100 * i, Gga(kNoon + i));
  chain.Feed(400, "GPZDA,120000.40,20,06,2026,00,00");
  chain.Feed(500, Gga(kNoon + 5));
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 1U);
  EXPECT_EQ(chain.assembler.stats().undated, 5U);
  EXPECT_EQ(chain.fixes.back().time, Utc(6, 20, 12, 0, 0, 500));
}

TEST(GnssEpochTime, LeapSecond) {
  Chain chain;
  const auto feed = [&](const std::string& time, const std::string& date) {
    chain.Feed(0, "GPRMC," + time + ",A,3510.0,N,13658.0,E,2.00,090.0," + date + ",,,A");
  };
  feed("235959.00", "311216");
  feed("235959.50", "311216");
  feed("235960.00", "311216");
  feed("235960.50", "311216");
  feed("000000.00", "010117");
  feed("000000.50", "010117");
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 6U);
  for (std::size_t i = 1; i < 6; ++i)
    EXPECT_EQ(chain.fixes[i].time - chain.fixes[i - 1].time, core::Milliseconds(500)) << i;
}

TEST(GnssEpochTime, WeekRolloverOfAnOldReceiver) {
  // A receiver that lives 1024 weeks in the past says 4 November 2006 for 20 June 2026.
  GnssEpochConfig config;
  config.not_before = core::FromCivil({2026, 1, 1, 0, 0, 0});
  Chain chain(config);
  for (std::int64_t i = 0; i < 5; ++i) {
    chain.Feed(100 * i, Gga(kNoon + i));
    chain.Feed(100 * i + 5, Rmc(kNoon + i, "041106"));
  }
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 5U);
  EXPECT_EQ(chain.fixes[0].time, Utc(6, 20, 12, 0, 0));
  EXPECT_EQ(chain.assembler.stats().rollovers, 5U);
}

TEST(GnssEpochTime, RepeatedAndOldEpochsAreRejected) {
  Chain chain;
  for (std::int64_t i = 0; i < 10; ++i) {
    chain.Feed(100 * i, Gga(kNoon + i));
    chain.Feed(100 * i + 5, Rmc(kNoon + i));
  }
  chain.Feed(1000, Rmc(kNoon + 3));
  chain.Feed(1005, Gga(kNoon + 3));
  EXPECT_EQ(chain.fixes.size(), 10U);
  EXPECT_EQ(chain.assembler.stats().rejected_times, 2U);
  chain.Feed(1100, Gga(kNoon + 10));
  chain.Feed(1105, Rmc(kNoon + 10));
  ASSERT_EQ(chain.fixes.size(), 11U);
}

TEST(GnssEpochTime, OneWrongTimeDoesNotPoisonTheRest) {
  Chain chain;
  for (std::int64_t i = 0; i < 10; ++i) {
    chain.Feed(1000 * i + 1, Gga(kNoon + 10 * i));
    // A damaged hour with the right checksum.
    chain.Feed(1000 * i + 5, Rmc(i == 6 ? kNoon + 36000 * 7 : kNoon + 10 * i));
  }
  chain.Finish();
  ASSERT_EQ(chain.fixes.size(), 10U);
  for (std::size_t i = 1; i < chain.fixes.size(); ++i)
    EXPECT_EQ(chain.fixes[i].time - chain.fixes[i - 1].time, core::Seconds(1)) << i;
}

TEST(GnssEpochTime, AWrongDateIsDoubtedUntilItIsRepeated) {
  Chain chain;
  for (std::int64_t i = 0; i < 12; ++i) {
    chain.Feed(1000 * i + 1, Gga(kNoon + 10 * i));
    chain.Feed(1000 * i + 5, Rmc(kNoon + 10 * i, i == 4 ? "200646" : i >= 8 ? "210626" : "200626"));
  }
  chain.Finish();
  // Epoch 4 is in doubt (undated), 8 and 9 too; from the third agreement on the new date counts.
  ASSERT_EQ(chain.fixes.size(), 9U);
  EXPECT_EQ(chain.assembler.stats().undated, 3U);
  EXPECT_EQ(chain.fixes[4].time, Utc(6, 20, 12, 0, 5));
  EXPECT_EQ(chain.fixes.back().time, Utc(6, 21, 12, 0, 11));
}

TEST(GnssEpochTime, ANewTimeLineIsBelievedAfterFiveEpochs) {
  Chain chain;
  for (std::int64_t i = 0; i < 10; ++i) chain.Feed(1000 * i + 1, Rmc(kNoon + 10 * i));
  // The receiver learns the leap seconds: two seconds back.
  for (std::int64_t i = 10; i < 20; ++i) chain.Feed(1000 * i + 1, Rmc(kNoon + 10 * i - 60));
  chain.Finish();
  EXPECT_EQ(chain.assembler.stats().time_steps, 1U);
  EXPECT_EQ(chain.fixes.back().time, Utc(6, 20, 12, 0, 13));
  EXPECT_EQ(chain.fixes.size(), 16U);
}

}  // namespace
}  // namespace kawara::drivers
