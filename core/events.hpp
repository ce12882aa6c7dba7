#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/fixed_text.hpp"
#include "core/spsc_ring.hpp"
#include "core/time.hpp"

namespace kawara::core {

enum class Severity : std::uint8_t {
  kInfo = 0,      ///< nothing is wrong
  kWarnLow = 1,   ///< one part is degraded and helps itself
  kWarnHigh = 2,  ///< the mission suffers: somebody should look
  kFatal = 3,     ///< the program cannot go on
};
const char* ToString(Severity s);  ///< "info", "warn-low", "warn-high", "fatal"

using EventText = FixedText<200>;

/// Something a person may want to know.
struct Event {
  MonoTime stamp;
  Severity severity = Severity::kInfo;
  const char* name = "";  ///< static string: "gps.unplugged"
  std::uint32_t suppressed =
      0;           ///< of the same name, held back since the last one that went through
  EventText text;  ///< one line
};

/// Where one thread leaves its events and a slower thread picks them up. Leaving one is real-time
/// safe.
///
/// Throttled by name: the first goes through at once, after that at most one per `throttle` with
/// the number held back since; one more severe than the last that went through, and every kFatal,
/// go through at once. Time is what the caller passes in, never a clock: the same inputs give the
/// same events. If it runs backwards (another log is played) the throttle opens.
///
/// Push side: one thread (make one Events per thread that reports). TryPop/dropped: one slower
/// thread.
class Events {
 public:
  explicit Events(Duration throttle = Seconds(10)) : throttle_(throttle) {}

  /// `name` must be a string literal (kept by pointer). Text beyond 200 bytes is cut.
  void Push(MonoTime now, Severity severity, const char* name, const EventText& text);
  void Info(MonoTime now, const char* name, const EventText& text) {
    Push(now, Severity::kInfo, name, text);
  }
  void WarnLow(MonoTime now, const char* name, const EventText& text) {
    Push(now, Severity::kWarnLow, name, text);
  }
  void WarnHigh(MonoTime now, const char* name, const EventText& text) {
    Push(now, Severity::kWarnHigh, name, text);
  }
  void Fatal(MonoTime now, const char* name, const EventText& text) {
    Push(now, Severity::kFatal, name, text);
  }
  /// Lets the last held-back event of each name out once its time is over, so that the end of a
  /// burst is not silent. Call it now and then (1 Hz) from the pushing thread.
  void Flush(MonoTime now);

  /// Oldest first; false when there is none.
  bool TryPop(Event& out) { return ring_.TryPop(out); }
  /// Events lost because nobody popped in time. Any thread.
  std::uint64_t dropped() const { return ring_.dropped(); }

  /// Names beyond this many share one throttle entry.
  static constexpr std::size_t kMaxNames = 96;

 private:
  struct Name {
    const char* name = nullptr;
    MonoTime last;  ///< when one went through
    Severity last_severity = Severity::kInfo;
    std::uint32_t suppressed = 0;
    Event held;  ///< the newest one held back, meaningful while suppressed > 0
  };

  Name& Find(const char* name, bool& is_new);
  bool IsOpen(const Name& entry, MonoTime now) const;
  void Emit(Name& entry, const Event& event);

  const Duration throttle_;
  std::size_t names_used_ = 0;
  std::array<Name, kMaxNames> names_{};
  SpscRing<Event, 256> ring_;
};

}  // namespace kawara::core
