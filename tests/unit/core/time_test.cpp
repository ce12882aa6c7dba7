#include "core/time.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <type_traits>

namespace kawara::core {
namespace {

constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();

UtcTime Utc(int year, int month, int day, int hour = 0, int minute = 0, int second = 0,
            std::int32_t ns = 0) {
  return FromCivil({year, month, day, hour, minute, second, ns});
}

static_assert(!std::is_convertible_v<GpsTime, UtcTime> &&
              !std::is_convertible_v<MonoTime, GpsTime>);
static_assert(!std::is_convertible_v<std::int64_t, GpsTime>);
template <class A, class B>
concept Comparable = requires(A a, B b) {
  a < b;
};
template <class A, class B>
concept Subtractable = requires(A a, B b) {
  a - b;
};
static_assert(Comparable<GpsTime, GpsTime> && !Comparable<GpsTime, UtcTime>);
static_assert(Subtractable<GpsTime, GpsTime> && !Subtractable<GpsTime, MonoTime>);

TEST(Duration, FromSecondsRoundsAndClamps) {
  EXPECT_EQ(DurationFromSeconds(0.5).count(), 500'000'000);
  EXPECT_EQ(DurationFromSeconds(-1.4e-9).count(), -1);
  EXPECT_EQ(DurationFromSeconds(0.1 + 0.2).count(), 300'000'000);
  EXPECT_GT(DurationFromSeconds(1e300).count(), 9'000'000'000'000'000'000);
  EXPECT_LT(DurationFromSeconds(-1e300).count(), -9'000'000'000'000'000'000);
}

TEST(GpsWeek, SplitsAndJoinsAlsoBeforeTheEpoch) {
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, kGpsWeek.count(), kGpsWeek.count() - 1,
        -kGpsWeek.count(), -kGpsWeek.count() - 1, kMax, kMin}) {
    const GpsWeekTime w = ToWeek(GpsTime::FromNs(ns));
    EXPECT_GE(w.time_of_week.count(), 0) << ns;
    EXPECT_LT(w.time_of_week, kGpsWeek) << ns;
    EXPECT_EQ(FromWeek(w).ns(), ns);
  }
}

TEST(GpsWeek, AbsurdWeeksSaturate) {
  EXPECT_EQ(FromWeek({std::numeric_limits<std::int32_t>::max(), {}}).ns(), kMax);
  EXPECT_EQ(FromWeek({std::numeric_limits<std::int32_t>::min(), {}}).ns(), kMin);
}

struct Rollover {
  const char* name;
  std::int32_t week;  ///< first full week of the new count
  UtcTime date;
};
class GpsRollover : public ::testing::TestWithParam<Rollover> {};
/// The ten-bit week number falls back to 0 at these midnights (GPS time).
TEST_P(GpsRollover, WeekBeforeAndAfterAreTold) {
  const Rollover& r = GetParam();
  const GpsTime first = FromWeek({r.week, {}});
  EXPECT_EQ(first, ToGps(r.date) - Seconds(LeapSeconds().OffsetAt(r.date)));
  // A reference up to half a count away, on both sides, tells which.
  for (const int weeks_off : {-511, -100, -1, 0, 1, 100, 511}) {
    const GpsTime reference = first + weeks_off * kGpsWeek;
    EXPECT_EQ(ResolveWeek(0, reference), r.week) << weeks_off;
  }
  EXPECT_EQ(ResolveWeek(1023, first - Seconds(1)), r.week - 1);
  EXPECT_EQ(ResolveWeek(1023, first + Seconds(1)), r.week - 1);
  EXPECT_EQ(ResolveWeek(0, first - Seconds(1)), r.week);
}
INSTANTIATE_TEST_SUITE_P(Table, GpsRollover,
                         ::testing::Values(Rollover{"1999", 1024, Utc(1999, 8, 22)},
                                           Rollover{"2019", 2048, Utc(2019, 4, 7)},
                                           Rollover{"2038", 3072, Utc(2038, 11, 21)}));

TEST(ResolveTimeOfWeek, PicksTheNearestAcrossTheWeekEnd) {
  const GpsTime week = FromWeek({2300, {}});
  EXPECT_EQ(ResolveTimeOfWeek(kGpsWeek - Seconds(1), week + Seconds(1)), week - Seconds(1));
  EXPECT_EQ(ResolveTimeOfWeek(Seconds(1), week - Seconds(1)), week + Seconds(1));
  EXPECT_EQ(ResolveTimeOfWeek(Seconds(1), week + Seconds(1)), week + Seconds(1));
}

TEST(ResolveTimeOfDay, PicksTheNearestAcrossMidnight) {
  const UtcTime midnight = Utc(2025, 7, 9);
  EXPECT_EQ(ResolveTimeOfDay(kDay - Milliseconds(100), midnight + Seconds(5)),
            midnight - Milliseconds(100));
  EXPECT_EQ(ResolveTimeOfDay(Milliseconds(100), midnight - Seconds(5)),
            midnight + Milliseconds(100));
  EXPECT_EQ(ResolveTimeOfDay(Duration(0), midnight - Nanoseconds(1)), midnight);
  // 11:59:59 away on both sides.
  EXPECT_EQ(ResolveTimeOfDay(Duration(0), midnight + std::chrono::hours(12) - Seconds(1)),
            midnight);
  EXPECT_EQ(ResolveTimeOfDay(Duration(0), midnight - std::chrono::hours(12) + Seconds(1)),
            midnight);
}

TEST(ResolveTimeOfDay, BeforeThePosixEpoch) {
  const UtcTime midnight = Utc(1965, 3, 1);
  EXPECT_EQ(ResolveTimeOfDay(kDay - Seconds(1), midnight), midnight - Seconds(1));
}

TEST(Resolve, ExtremeReferencesSaturateWithoutOverflow) {
  for (const std::int64_t ns : {kMin, kMax}) {
    ResolveTimeOfDay(kDay - Nanoseconds(1), UtcTime::FromNs(ns));
    ResolveTimeOfWeek(kGpsWeek - Nanoseconds(1), GpsTime::FromNs(ns));
    ResolveTimeOfWeek(Duration(ns), GpsTime::FromNs(ns / -2));
    ResolveWeek(std::numeric_limits<std::int32_t>::min(), GpsTime::FromNs(ns));
    const UtcTime utc = ToUtc(GpsTime::FromNs(ns));
    const GpsTime gps = ToGps(UtcTime::FromNs(ns));
    EXPECT_EQ(utc.ns() > 0, ns > 0);
    EXPECT_EQ(gps.ns() > 0, ns > 0);
  }
}

TEST(LeapSeconds, TableAgainstTheDatesOfBulletinC) {
  const LeapSeconds leaps;
  struct Row {
    UtcTime since;
    int offset_s;
  };
  for (const Row& row :
       {Row{Utc(1980, 1, 6), 0},  Row{Utc(1981, 7, 1), 1},   Row{Utc(1982, 7, 1), 2},
        Row{Utc(1983, 7, 1), 3},  Row{Utc(1985, 7, 1), 4},   Row{Utc(1988, 1, 1), 5},
        Row{Utc(1990, 1, 1), 6},  Row{Utc(1991, 1, 1), 7},   Row{Utc(1992, 7, 1), 8},
        Row{Utc(1993, 7, 1), 9},  Row{Utc(1994, 7, 1), 10},  Row{Utc(1996, 1, 1), 11},
        Row{Utc(1997, 7, 1), 12}, Row{Utc(1999, 1, 1), 13},  Row{Utc(2006, 1, 1), 14},
        Row{Utc(2009, 1, 1), 15}, Row{Utc(2012, 7, 1), 16},  Row{Utc(2015, 7, 1), 17},
        Row{Utc(2017, 1, 1), 18}, Row{Utc(2026, 11, 22), 18}}) {
    EXPECT_EQ(leaps.OffsetAt(row.since), row.offset_s);
    if (row.offset_s > 0 && row.since <= Utc(2017, 1, 1)) {
      EXPECT_EQ(leaps.OffsetAt(row.since - Nanoseconds(1)), row.offset_s - 1);
    }
  }
}

/// Around 2016-12-31T23:59:60 second by second, GPS time going evenly.
TEST(LeapSeconds, TheSecondItselfBothWays) {
  const UtcTime midnight = Utc(2017, 1, 1);
  const GpsTime before = ToGps(midnight - Seconds(1));  // 23:59:59
  EXPECT_EQ(ToUtc(before), midnight - Seconds(1));
  EXPECT_EQ(ToUtc(before + Seconds(1)), midnight);  // 23:59:60 has the number of 00:00:00
  EXPECT_EQ(ToUtc(before + Milliseconds(1500)), midnight + Milliseconds(500));
  EXPECT_EQ(ToUtc(before + Seconds(2)), midnight);  // 00:00:00
  EXPECT_EQ(ToUtc(before + Seconds(3)), midnight + Seconds(1));
  EXPECT_EQ(ToGps(midnight), before + Seconds(2));
  EXPECT_EQ(ToGps(midnight + Milliseconds(500)), before + Milliseconds(2500));
  EXPECT_EQ(ToGps(midnight) - ToGps(midnight - Nanoseconds(1)), Seconds(1) + Nanoseconds(1));
}

TEST(LeapSeconds, RoundTripsAwayFromTheSecond) {
  for (const UtcTime t :
       {Utc(1970, 1, 1), Utc(1980, 1, 6), Utc(1999, 12, 31, 23, 59, 59, 999'999'999),
        Utc(2017, 1, 1), Utc(2025, 7, 8, 19, 34, 18), Utc(2100, 1, 1)}) {
    EXPECT_EQ(ToUtc(ToGps(t)), t);
  }
}

TEST(LeapSeconds, KnownInstants) {
  // Week 2374, 243258.499 s of the week: 2025-07-08 19:34:00.499 UTC.
  EXPECT_EQ(ToUtc(FromWeek({2374, DurationFromSeconds(243258.499)})),
            Utc(2025, 7, 8, 19, 34, 0, 499'000'000));
  EXPECT_EQ(ToGps(Utc(1980, 1, 6)).ns(), 0);
}

TEST(LeapSeconds, AnnouncedOnesAreUsedAndKept) {
  LeapSeconds leaps;
  const UtcTime first = Utc(2029, 1, 1), second = Utc(2031, 7, 1);
  EXPECT_TRUE(leaps.Announce(first, 19));
  EXPECT_TRUE(leaps.Announce(first, 19));
  EXPECT_TRUE(leaps.Announce(second, 20));
  EXPECT_EQ(leaps.OffsetAt(first - Nanoseconds(1)), 18);
  EXPECT_EQ(leaps.OffsetAt(first), 19);
  EXPECT_EQ(leaps.OffsetAt(second), 20);
  EXPECT_EQ(ToUtc(ToGps(first - Seconds(1), leaps) + Seconds(1), leaps), first);
  EXPECT_EQ(ToUtc(ToGps(first - Seconds(1), leaps) + Seconds(2), leaps), first);
}

TEST(LeapSeconds, ANegativeOneSkipsASecond) {
  LeapSeconds leaps;
  const UtcTime since = Utc(2029, 7, 1);
  ASSERT_TRUE(leaps.Announce(since, 17));
  const GpsTime last = ToGps(since - Seconds(2), leaps);  // 23:59:58, the last second of the day
  EXPECT_EQ(ToUtc(last, leaps), since - Seconds(2));
  EXPECT_EQ(ToUtc(last + Milliseconds(999), leaps), since - Milliseconds(1001));
  EXPECT_EQ(ToUtc(last + Seconds(1), leaps), since);
}

TEST(LeapSeconds, NonsenseIsRefused) {
  LeapSeconds leaps;
  EXPECT_FALSE(leaps.Announce(Utc(2029, 1, 1), 20));
  EXPECT_FALSE(leaps.Announce(Utc(2029, 1, 1), 0));
  EXPECT_FALSE(leaps.Announce(Utc(2029, 1, 1), std::numeric_limits<int>::min()));
  EXPECT_FALSE(leaps.Announce(Utc(2029, 1, 1), std::numeric_limits<int>::max()));
  EXPECT_FALSE(leaps.Announce(Utc(2016, 1, 1), 18));
  EXPECT_FALSE(leaps.Announce(UtcTime::FromNs(kMin), 18));
  ASSERT_TRUE(leaps.Announce(Utc(2029, 1, 1), 19));
  EXPECT_FALSE(leaps.Announce(Utc(2028, 1, 1), 17));
  EXPECT_EQ(leaps.OffsetAt(Utc(2030, 1, 1)), 19);
}

TEST(Civil, KnownDates) {
  EXPECT_EQ(Utc(1970, 1, 1).ns(), 0);
  EXPECT_EQ(Utc(2000, 3, 1).ns() / 1'000'000'000, 951868800);
  EXPECT_EQ(Utc(2038, 1, 19, 3, 14, 8).ns() / 1'000'000'000, std::int64_t{1} << 31);
  const CivilTime c = ToCivil(UtcTime::FromNs(-1));
  EXPECT_EQ(c.year, 1969);
  EXPECT_EQ(c.second, 59);
  EXPECT_EQ(c.nanosecond, 999'999'999);
}

TEST(Civil, RoundTripOverAllOf64Bits) {
  for (int i = 0; i <= 2000; ++i) {
    const auto ns = static_cast<std::int64_t>(
        (std::uint64_t{1} << 63) + static_cast<std::uint64_t>(i) * (~std::uint64_t{0} / 2000));
    const CivilTime c = ToCivil(UtcTime::FromNs(ns));
    EXPECT_EQ(FromCivil(c).ns(), ns);
    EXPECT_TRUE(IsValid(c) || c.year < 1678 || c.year > 2261) << ns;
  }
}

TEST(Civil, AbsurdFieldsSaturate) {
  EXPECT_EQ(Utc(32767, 12, 31).ns(), kMax);
  EXPECT_EQ(Utc(-32767, 1, 1).ns(), kMin);
  constexpr int kBig = std::numeric_limits<int>::max();
  FromCivil({kBig, kBig, kBig, kBig, kBig, kBig, kBig});
}

TEST(Civil, Validity) {
  EXPECT_TRUE(IsValid({2024, 2, 29, 0, 0, 0, 0}));
  EXPECT_TRUE(IsValid({2016, 12, 31, 23, 59, 60, 0}));
  for (const CivilTime& c :
       {CivilTime{2023, 2, 29, 0, 0, 0, 0}, CivilTime{1900, 2, 29, 0, 0, 0, 0},
        CivilTime{2023, 13, 1, 0, 0, 0, 0}, CivilTime{2023, 0, 1, 0, 0, 0, 0},
        CivilTime{2023, 1, 0, 0, 0, 0, 0}, CivilTime{2023, 4, 31, 0, 0, 0, 0},
        CivilTime{2023, 1, 1, 24, 0, 0, 0}, CivilTime{2023, 1, 1, 0, 60, 0, 0},
        CivilTime{2023, 1, 1, 0, 0, 60, 0}, CivilTime{2016, 12, 31, 23, 59, 61, 0},
        CivilTime{2023, 1, 1, -1, 0, 0, 0}, CivilTime{2023, 1, 1, 0, 0, 0, -1},
        CivilTime{2023, 1, 1, 0, 0, 0, 1'000'000'000}, CivilTime{1600, 1, 1, 0, 0, 0, 0},
        CivilTime{2300, 1, 1, 0, 0, 0, 0}}) {
    EXPECT_FALSE(IsValid(c)) << c.year << "-" << c.month << "-" << c.day << " " << c.hour << ":"
                             << c.minute << ":" << c.second;
  }
}

TEST(Mono, GoesForward) {
  const MonoTime a = MonoNow();
  EXPECT_GE(MonoNow(), a);
  EXPECT_TRUE(a.IsSet());
}

}  // namespace
}  // namespace kawara::core
