#include "drivers/gnss_clock.hpp"

namespace kawara::drivers {
namespace {

constexpr core::Duration kRollover = 1024 * core::kGpsWeek;
constexpr core::Duration kSecond = core::Seconds(1);
constexpr int kBelieve = 3;

bool IsFar(core::UtcTime a, core::UtcTime b) {
  const core::Duration distance = a - b;
  return distance >= core::kDay / 2 || distance <= -core::kDay / 2;
}

}  // namespace

void GnssClock::SetDate(int year, int month, int day, core::Duration time_of_day,
                        core::MonoTime arrival) {
  core::UtcTime utc = core::FromCivil({.year = year, .month = month, .day = day}) + time_of_day;
  if (not_before_.IsSet() && utc < not_before_) {
    ++rollovers_;
    while (utc < not_before_) utc += kRollover;
  }
  if (dated_by_receiver_ && IsFar(utc, Expected(arrival))) {
    doubts_ = doubts_ > 0 && !IsFar(utc, doubted_) ? doubts_ + 1 : 1;
    doubted_ = utc;
    if (doubts_ < kBelieve) return;
  }
  doubts_ = 0;
  dated_by_receiver_ = true;
  anchor_ = utc;
  anchor_arrival_ = arrival;
}

/// What the receiver's UTC should be about now.
core::UtcTime GnssClock::Expected(core::MonoTime arrival) const {
  const bool both = anchor_arrival_.IsSet() && arrival.IsSet();
  return both && arrival > anchor_arrival_ ? anchor_ + (arrival - anchor_arrival_) : anchor_;
}

std::optional<core::GpsTime> GnssClock::OfTimeOfDay(core::Duration time_of_day,
                                                    core::MonoTime arrival) {
  if (!has_date() || doubts_ > 0) return std::nullopt;
  // 23:59:60 shares its POSIX number with 00:00:00: go through the second before.
  const core::Duration into_leap = time_of_day >= core::kDay ? kSecond : core::Duration{};
  const core::UtcTime utc = core::ResolveTimeOfDay(time_of_day - into_leap, Expected(arrival));
  anchor_ = utc;
  anchor_arrival_ = arrival;
  return core::ToGps(utc) + into_leap;
}

std::optional<core::GpsTime> GnssClock::OfTimeOfWeek(core::Duration time_of_week,
                                                     core::MonoTime arrival) const {
  if (!has_date()) return std::nullopt;
  return core::ResolveTimeOfWeek(time_of_week, core::ToGps(Expected(arrival)));
}

core::Duration GnssClock::TimeOfDay(core::GpsTime time) {
  const core::LeapSeconds leaps;
  const core::UtcTime utc = core::ToUtc(time, leaps);
  core::Duration of_day = core::Duration(utc.ns() % core::kDay.count());
  if (of_day < core::Duration{}) of_day += core::kDay;
  // In a leap second POSIX counts the new day's first second twice; the receiver prints 23:59:60.
  if (of_day < kSecond && core::ToGps(utc, leaps) > time) of_day += core::kDay;
  return of_day;
}

}  // namespace kawara::drivers
