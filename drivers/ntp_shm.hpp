#pragma once
#include <cstdint>
#include <optional>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

/// One comparison of the computer's clock with the true time.
struct ClockComparison {
  core::UtcTime utc;             ///< the true time ...
  std::int64_t realtime_ns = 0;  ///< ... when CLOCK_REALTIME said this
  double sigma_s = 0.0;          ///< of `utc`, one deviation
};

/// Hands a reference time to the service that keeps the computer's clock, chronyd or ntpd, through
/// the shared memory both read ("SHM refclock", ntpd's driver 28, unit N: key 0x4e545030 + N). The
/// service makes the segment, and with it decides who may write; it may be restarted at any time.
/// One thread.
class NtpShm {
 public:
  explicit NtpShm(int unit) : unit_(unit) {}
  ~NtpShm() { Detach(); }
  NtpShm(const NtpShm&) = delete;
  NtpShm& operator=(const NtpShm&) = delete;

  /// Puts one comparison there, over the one before. Errors, one line with its cure: kNotFound (the
  /// service does not run or has no such reference clock), kPermission, kUnavailable.
  core::Expected<void> Tell(const ClockComparison& comparison);

 private:
  struct Segment;
  core::Expected<void> Attach();
  void Detach();

  int unit_;
  int id_ = -1;
  Segment* segment_ = nullptr;
};

}  // namespace kawara::drivers
