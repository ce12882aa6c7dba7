#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/time.hpp"

namespace kawara::onboard {

/// The instants at which the receiver saw a pulse at its event input ($PASHR,TTT): the shutter on
/// the GPS scale, good to a microsecond whatever this computer's clock does. A mark has no number,
/// and not every pulse is told of (only the first between two epochs; none without a position), so
/// an exposure finds its own by time, never by order: a lost mark costs itself and shifts nothing.
///
/// Source: Z-Family Technical Reference Manual p.120, 200. Real-time safe; one thread; fixed
/// memory.
class EventMarks {
 public:
  struct Stats {
    std::int64_t used = 0;
    std::int64_t missing = 0;  ///< exposures that got none
    std::int64_t stray = 0;    ///< marks that no exposure was near
  };

  void OnMark(core::GpsTime mark);
  /// The mark nearest to `expected` and not farther than `window`, if no exposure had it before.
  /// Each is given away once.
  std::optional<core::GpsTime> Take(core::GpsTime expected, core::Duration window);
  /// An exposure went without. True: that makes kGiveUp in a row, and is said once until a mark
  /// comes again.
  bool Miss();

  /// It is worth waiting for them.
  bool alive() const { return missed_in_row_ < kGiveUp; }
  const Stats& stats() const { return stats_; }

  static constexpr int kGiveUp = 5;

 private:
  struct Slot {
    core::GpsTime mark;  ///< not set: empty
    bool used = false;
  };
  std::array<Slot, 16> slots_{};
  std::size_t next_slot_ = 0;
  int missed_in_row_ = 0;
  Stats stats_;
};

}  // namespace kawara::onboard
