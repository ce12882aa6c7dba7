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

/// Sums and products of times in here are made in 128 bits and brought back by Saturate: stamps
/// from outside may hold anything, and signed overflow is undefined.
__extension__ using Int128 = __int128;

std::int64_t Saturate(Int128 ns) {
  constexpr Int128 kMin = std::numeric_limits<std::int64_t>::min();
  constexpr Int128 kMax = std::numeric_limits<std::int64_t>::max();
  return static_cast<std::int64_t>(std::clamp(ns, kMin, kMax));
}

template <class Int>
Int FloorDiv(Int a, Int b) {
  const Int q = a / b;
  return (a % b != 0 && ((a < 0) != (b < 0))) ? q - 1 : q;
}

/// value + k * period nearest to reference; the later one of two equally near.
std::int64_t NearestCongruent(Int128 value, Int128 period, Int128 reference) {
  const Int128 k = FloorDiv(reference - value + period / 2, period);
  return Saturate(value + k * period);
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
  const std::int64_t week = FloorDiv(t.ns(), std::int64_t{kGpsWeek.count()});
  return {static_cast<std::int32_t>(week),
          Duration(static_cast<std::int64_t>(t.ns() - Int128{week} * kGpsWeek.count()))};
}

GpsTime FromWeek(GpsWeekTime w) {
  return GpsTime::FromNs(Saturate(Int128{w.week} * kGpsWeek.count() + w.time_of_week.count()));
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
  const std::int64_t s = FloorDiv(t.ns(), kNsPerS);
  int offset = 0;
  for (const Leap& leap : kLeaps) {
    if (s < leap.since_posix_s) break;
    offset = leap.gps_minus_utc_s;
  }
  for (std::size_t i = 0; i < announced_count_ && t >= announced_[i].since; ++i) {
    offset = announced_[i].offset_s;
  }
  return offset;
}

int LeapSeconds::OffsetAt(GpsTime t) const {
  // 23:59:60 shares its POSIX number with 00:00:00 of the next day, which is what the OLD offset
  // gives during the leap second; the new one begins after it. On this count (GPS time minus the
  // epochs' distance) that is at since + new offset. For a negative leap second (never yet) the
  // same formula holds.
  const Int128 gps_posix_ns = Int128{t.ns()} + Int128{kGpsEpochPosixS} * kNsPerS;
  int offset = 0;
  for (const Leap& leap : kLeaps) {
    if (gps_posix_ns < Int128{leap.since_posix_s + leap.gps_minus_utc_s} * kNsPerS) break;
    offset = leap.gps_minus_utc_s;
  }
  for (std::size_t i = 0; i < announced_count_; ++i) {
    const Announcement& a = announced_[i];
    if (gps_posix_ns < Int128{a.since.ns()} + Int128{a.offset_s} * kNsPerS) break;
    offset = a.offset_s;
  }
  return offset;
}

bool LeapSeconds::Announce(UtcTime since, int offset_s) {
  if (offset_s <= 0 || since < UtcTime::FromNs(kLeaps.back().since_posix_s * kNsPerS)) return false;
  if (OffsetAt(since) == offset_s) return true;  // known already; receivers repeat themselves
  if (announced_count_ > 0 && since <= announced_[announced_count_ - 1].since) return false;
  if (announced_count_ == announced_.size()) return false;
  const int current = OffsetAt(since);
  if (offset_s > current + 1 || offset_s < current - 1) return false;
  announced_[announced_count_++] = {since, offset_s};
  return true;
}

UtcTime ToUtc(GpsTime t, const LeapSeconds& leaps) {
  return UtcTime::FromNs(
      Saturate(Int128{t.ns()} + Int128{kGpsEpochPosixS - leaps.OffsetAt(t)} * kNsPerS));
}

GpsTime ToGps(UtcTime t, const LeapSeconds& leaps) {
  return GpsTime::FromNs(
      Saturate(Int128{t.ns()} + Int128{leaps.OffsetAt(t) - kGpsEpochPosixS} * kNsPerS));
}

CivilTime ToCivil(UtcTime t) {
  using std::chrono::days;
  const std::int64_t day_ns = kDay.count();
  const std::int64_t day = FloorDiv(t.ns(), day_ns);
  const std::int64_t rest_ns = (t.ns() % day_ns + day_ns) % day_ns;
  const std::int64_t rest_s = rest_ns / kNsPerS;
  const std::chrono::year_month_day date{std::chrono::sys_days{days{day}}};
  return {static_cast<int>(date.year()),
          static_cast<int>(static_cast<unsigned>(date.month())),
          static_cast<int>(static_cast<unsigned>(date.day())),
          static_cast<int>(rest_s / 3600),
          static_cast<int>(rest_s / 60 % 60),
          static_cast<int>(rest_s % 60),
          static_cast<std::int32_t>(rest_ns % kNsPerS)};
}

UtcTime FromCivil(const CivilTime& c) {
  using namespace std::chrono;
  const sys_days day{year{c.year} / month{static_cast<unsigned>(c.month)} /
                     std::chrono::day{static_cast<unsigned>(c.day)}};
  const Int128 s = Int128{day.time_since_epoch().count()} * 86400 + Int128{c.hour} * 3600 +
                   Int128{c.minute} * 60 + c.second;
  return UtcTime::FromNs(Saturate(s * kNsPerS + c.nanosecond));
}

bool IsValid(const CivilTime& c) {
  using namespace std::chrono;
  if (c.year < 1678 || c.year > 2261 || c.month < 1 || c.month > 12 || c.day < 1) return false;
  const year_month_day ymd{year{c.year}, month{static_cast<unsigned>(c.month)},
                           day{static_cast<unsigned>(c.day)}};
  const int seconds = c.hour == 23 && c.minute == 59 ? 61 : 60;
  return ymd.ok() && c.hour >= 0 && c.hour < 24 && c.minute >= 0 && c.minute < 60 &&
         c.second >= 0 && c.second < seconds && c.nanosecond >= 0 && c.nanosecond < kNsPerS;
}

}  // namespace kawara::core
