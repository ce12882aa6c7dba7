#pragma once
#include <array>
#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace kawara::core {

/// Spans of time are std::chrono::nanoseconds everywhere; a double of seconds only inside formulas.
using Duration = std::chrono::nanoseconds;

constexpr Duration Nanoseconds(std::int64_t ns) { return Duration(ns); }
constexpr Duration Milliseconds(std::int64_t ms) { return std::chrono::milliseconds(ms); }
constexpr Duration Seconds(std::int64_t s) { return std::chrono::seconds(s); }
/// Nearest nanosecond. The argument must be finite and within +-9.2e9 s; otherwise the result is
/// clamped.
Duration DurationFromSeconds(double seconds);
constexpr double ToSeconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }

/// A point on one named time scale, as integer nanoseconds since that scale's epoch. Points of
/// different scales do not compare, subtract or convert implicitly: that is the purpose of the
/// type.
template <class Scale>
class TimePoint {
 public:
  constexpr TimePoint() = default;  ///< the scale's epoch; by convention "not set" (see IsSet)
  static constexpr TimePoint FromNs(std::int64_t ns) {
    TimePoint t;
    t.ns_ = ns;
    return t;
  }
  constexpr std::int64_t ns() const { return ns_; }
  constexpr bool IsSet() const { return ns_ != 0; }
  constexpr auto operator<=>(const TimePoint&) const = default;
  constexpr TimePoint operator+(Duration d) const { return FromNs(ns_ + d.count()); }
  constexpr TimePoint operator-(Duration d) const { return FromNs(ns_ - d.count()); }
  constexpr Duration operator-(TimePoint other) const { return Duration(ns_ - other.ns_); }
  constexpr TimePoint& operator+=(Duration d) {
    ns_ += d.count();
    return *this;
  }

 private:
  std::int64_t ns_ = 0;
};

struct GpsScale {};
struct UtcScale {};
struct MonoScale {};
/// Since 1980-01-06 00:00:00 GPS; continuous, no leap seconds.
using GpsTime = TimePoint<GpsScale>;
/// Since 1970-01-01 00:00:00 UTC counted as POSIX does: 86400 s a day, a leap second shares its
/// number with the second after it.
using UtcTime = TimePoint<UtcScale>;
/// CLOCK_MONOTONIC of this machine since its boot. Arrival stamps and deadlines; means nothing
/// elsewhere.
using MonoTime = TimePoint<MonoScale>;

/// CLOCK_MONOTONIC now. Real-time safe.
MonoTime MonoNow();

constexpr Duration kDay = std::chrono::hours(24);
constexpr Duration kGpsWeek = 7 * kDay;

/// GPS week (full count, no roll-over) and time of week [0, 7 d).
struct GpsWeekTime {
  std::int32_t week = 0;
  Duration time_of_week{};
};
GpsWeekTime ToWeek(GpsTime t);
GpsTime FromWeek(GpsWeekTime w);

/// The week number nearest to `reference` that equals `week_mod_1024` modulo 1024 (roll-overs 1999,
/// 2019, 2038).
std::int32_t ResolveWeek(std::int32_t week_mod_1024, GpsTime reference);
/// The time with this time of week nearest to `reference` (within half a week).
GpsTime ResolveTimeOfWeek(Duration time_of_week, GpsTime reference);
/// The time with this time of day [0, 24 h] nearest to `reference` (within 12 h): midnight is
/// handled here.
UtcTime ResolveTimeOfDay(Duration time_of_day, UtcTime reference);

/// GPS minus UTC. Knows the table of IERS Bulletin C up to the release date; a newer announcement
/// (or a receiver's own figure) is added by Announce. Value type, one thread.
class LeapSeconds {
 public:
  /// GPS - UTC [s] in force at t (18 since 2017-01-01).
  int OffsetAt(UtcTime t) const;
  int OffsetAt(GpsTime t) const;
  /// From `since` on GPS - UTC is `offset_s`. Accepted: what is in force anyway, and a change by
  /// one second after everything known so far (at most 8). False: refused, nothing changed.
  bool Announce(UtcTime since, int offset_s);

 private:
  struct Announcement {
    UtcTime since;
    int offset_s = 0;
  };
  std::array<Announcement, 8> announced_{};  ///< ascending
  std::size_t announced_count_ = 0;
};

/// Of the two GPS seconds that share a number of UtcTime at a leap second, ToGps gives the later.
/// All conversions saturate at the ends of 64 bits (years 1677 and 2262).
UtcTime ToUtc(GpsTime t, const LeapSeconds& leaps = {});
GpsTime ToGps(UtcTime t, const LeapSeconds& leaps = {});

/// Civil UTC date and time; month 1..12, day 1..31, second 0..60 (60 only in a leap second).
struct CivilTime {
  int year = 1970, month = 1, day = 1, hour = 0, minute = 0, second = 0;
  std::int32_t nanosecond = 0;
};
CivilTime ToCivil(UtcTime t);
/// Saturates; otherwise no range check (see IsValid). Second 60 gives 00:00:00 of the next day.
UtcTime FromCivil(const CivilTime& c);
bool IsValid(const CivilTime& c);

}  // namespace kawara::core
