#include "core/time.hpp"

#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kawara::core {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
/// 1980-01-06 00:00:00 on the POSIX count.
constexpr std::int64_t kGpsEpochPosixS = 315'964'800;

struct Leap {
  std::int64_t since_posix_s;  ///< first second with the new offset
  int gps_minus_utc_s;
};
/// IERS Bulletin C; complete as of 2026-11 (the newest leap second is 2016-12-31T23:59:60).
constexpr std::array<Leap, 19> kLeaps{{{kGpsEpochPosixS, 0},
                                       {362793600, 1},
                                       {394329600, 2},
                                       {425865600, 3},
                                       {489024000, 4},
                                       {567993600, 5},
                                       {631152000, 6},
                                       {662688000, 7},
                                       {709948800, 8},
                                       {741484800, 9},
                                       {773020800, 10},
                                       {820454400, 11},
                                       {867715200, 12},
                                       {915148800, 13},
                                       {1136073600, 14},
                                       {1230768000, 15},
                                       {1341100800, 16},
                                       {1435708800, 17},
                                       {1483228800, 18}}};

std::int64_t FloorDiv(std::int64_t a, std::int64_t b) {
  const std::int64_t q = a / b;
  return (a % b != 0 && ((a < 0) != (b < 0))) ? q - 1 : q;
}

/// value + k * period nearest to reference.
std::int64_t NearestCongruent(std::int64_t value, std::int64_t period, std::int64_t reference) {
  const std::int64_t k = FloorDiv(reference - value + period / 2, period);
  return value + k * period;
}

}  // namespace

Duration DurationFromSeconds(double seconds) {
  const double ns = seconds * 1e9;
  constexpr double kMax = 9.2e18;
  if (!(ns > -kMax)) return Duration(-static_cast<std::int64_t>(kMax));
  if (!(ns < kMax)) return Duration(static_cast<std::int64_t>(kMax));
  return Duration(std::llround(ns));
}

MonoTime MonoNow() {
  timespec ts{};
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return MonoTime::FromNs(ts.tv_sec * kNsPerS + ts.tv_nsec);
}

GpsWeekTime ToWeek(GpsTime t) {
  const std::int64_t week = FloorDiv(t.ns(), kGpsWeek.count());
  return {static_cast<std::int32_t>(week), Duration(t.ns() - week * kGpsWeek.count())};
}

GpsTime FromWeek(GpsWeekTime w) {
  return GpsTime::FromNs(w.week * kGpsWeek.count() + w.time_of_week.count());
}

std::int32_t ResolveWeek(std::int32_t week_mod_1024, GpsTime reference) {
  return static_cast<std::int32_t>(
      NearestCongruent(week_mod_1024 & 1023, 1024, ToWeek(reference).week));
}

GpsTime ResolveTimeOfWeek(Duration time_of_week, GpsTime reference) {
  return GpsTime::FromNs(NearestCongruent(time_of_week.count(), kGpsWeek.count(), reference.ns()));
}

UtcTime ResolveTimeOfDay(Duration time_of_day, UtcTime reference) {
  return UtcTime::FromNs(NearestCongruent(time_of_day.count(), kDay.count(), reference.ns()));
}

int LeapSeconds::OffsetAt(UtcTime t) const {
  if (announced_offset_s_ != 0 && t >= announced_since_) return announced_offset_s_;
  const std::int64_t s = FloorDiv(t.ns(), kNsPerS);
  int offset = 0;
  for (const Leap& leap : kLeaps) {
    if (s < leap.since_posix_s) break;
    offset = leap.gps_minus_utc_s;
  }
  return offset;
}

int LeapSeconds::OffsetAt(GpsTime t) const {
  // Seen from GPS time the new offset begins one second early: the leap second itself (23:59:60)
  // shares its POSIX number with 00:00:00 of the next day.
  const std::int64_t gps_posix_ns = t.ns() + kGpsEpochPosixS * kNsPerS;
  if (announced_offset_s_ != 0 &&
      gps_posix_ns >= announced_since_.ns() + announced_offset_s_ * kNsPerS) {
    return announced_offset_s_;
  }
  int offset = 0;
  for (const Leap& leap : kLeaps) {
    if (gps_posix_ns < (leap.since_posix_s + leap.gps_minus_utc_s) * kNsPerS) break;
    offset = leap.gps_minus_utc_s;
  }
  return offset;
}

bool LeapSeconds::Announce(UtcTime since, int offset_s) {
  const int current = OffsetAt(since - Nanoseconds(1));
  if (since < UtcTime::FromNs(kLeaps.back().since_posix_s * kNsPerS)) return false;
  if (std::abs(offset_s - current) > 1 || offset_s <= 0) return false;
  announced_since_ = since;
  announced_offset_s_ = offset_s;
  return true;
}

UtcTime ToUtc(GpsTime t, const LeapSeconds& leaps) {
  return UtcTime::FromNs(t.ns() + (kGpsEpochPosixS - leaps.OffsetAt(t)) * kNsPerS);
}

GpsTime ToGps(UtcTime t, const LeapSeconds& leaps) {
  return GpsTime::FromNs(t.ns() + (leaps.OffsetAt(t) - kGpsEpochPosixS) * kNsPerS);
}

CivilTime ToCivil(UtcTime t) {
  using namespace std::chrono;
  const sys_time<nanoseconds> point{nanoseconds(t.ns())};
  const sys_days day = floor<days>(point);
  const year_month_day ymd{day};
  const hh_mm_ss<nanoseconds> tod{point - day};
  return {static_cast<int>(ymd.year()),
          static_cast<int>(static_cast<unsigned>(ymd.month())),
          static_cast<int>(static_cast<unsigned>(ymd.day())),
          static_cast<int>(tod.hours().count()),
          static_cast<int>(tod.minutes().count()),
          static_cast<int>(tod.seconds().count()),
          static_cast<std::int32_t>(tod.subseconds().count())};
}

UtcTime FromCivil(const CivilTime& c) {
  using namespace std::chrono;
  const sys_days day{year{c.year} / month{static_cast<unsigned>(c.month)} /
                     std::chrono::day{static_cast<unsigned>(c.day)}};
  const auto ns = duration_cast<nanoseconds>(day.time_since_epoch()) + hours(c.hour) +
                  minutes(c.minute) + seconds(c.second) + nanoseconds(c.nanosecond);
  return UtcTime::FromNs(ns.count());
}

bool IsValid(const CivilTime& c) {
  using namespace std::chrono;
  if (c.year < 1678 || c.year > 2261 || c.month < 1 || c.month > 12 || c.day < 1) return false;
  const year_month_day ymd{year{c.year}, month{static_cast<unsigned>(c.month)},
                           day{static_cast<unsigned>(c.day)}};
  return ymd.ok() && c.hour >= 0 && c.hour < 24 && c.minute >= 0 && c.minute < 60 &&
         c.second >= 0 && c.second <= 60 && c.nanosecond >= 0 && c.nanosecond < kNsPerS;
}

}  // namespace kawara::core
