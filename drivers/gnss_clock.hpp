#pragma once
#include <optional>

#include "core/time.hpp"

namespace kawara::drivers {

/// Puts a date to the time of day that position sentences carry. The date comes from sentences that
/// have one, or from a rough time known beforehand, and is carried on over midnight, over gaps in
/// the stream (by the arrival stamps) and through leap seconds. Deterministic, no allocation. One
/// thread.
class GnssClock {
 public:
  /// `reference`: rough UTC, within 12 hours; not set: wait for a date. `not_before`: dates before
  /// it are 1024 weeks (or a multiple) late, the mark of a receiver that lived through a GPS week
  /// roll-over; not set: believed.
  GnssClock(core::UtcTime reference, core::UtcTime not_before)
      : anchor_(reference), not_before_(not_before) {}

  bool has_date() const { return anchor_.IsSet(); }
  /// A whole, valid date with its time of day, as the receiver said it. One that contradicts what
  /// was said before (by 12 hours or more) is in doubt until the third in a row that agrees with
  /// it.
  void SetDate(int year, int month, int day, core::Duration time_of_day, core::MonoTime arrival);
  /// The instant of a time of day that came in at `arrival`; 23:59:60 is 86400 s. No value: no date
  /// known yet. The clock goes on from there.
  std::optional<core::GpsTime> OfTimeOfDay(core::Duration time_of_day, core::MonoTime arrival);
  /// The same of a GPS time of week, without moving the clock.
  std::optional<core::GpsTime> OfTimeOfWeek(core::Duration time_of_week,
                                            core::MonoTime arrival) const;
  /// UTC time of day of an instant, as receivers print it (86400 s and more in a leap second).
  static core::Duration TimeOfDay(core::GpsTime time);

  /// How many dates were moved by 1024 weeks.
  std::uint64_t rollovers() const { return rollovers_; }

 private:
  core::UtcTime Expected(core::MonoTime arrival) const;

  core::UtcTime anchor_;
  core::MonoTime anchor_arrival_;
  core::UtcTime not_before_;
  bool dated_by_receiver_ = false;
  core::UtcTime doubted_;  ///< the newest date that contradicts the anchor
  int doubts_ = 0;         ///< how many in a row
  std::uint64_t rollovers_ = 0;
};

}  // namespace kawara::drivers
