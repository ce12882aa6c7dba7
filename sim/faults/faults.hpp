#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::sim {

enum class FaultKind {
  kGpsUnplug,     ///< cable out: the device node goes away, and comes back under another number
  kGpsSilent,     ///< open, but nothing comes
  kGpsGarbage,    ///< the right amount of wrong bytes
  kGpsBadSum,     ///< every sentence with a wrong checksum
  kGpsNoFix,      ///< the receiver says that it has no solution
  kGpsStuck,      ///< the line repeats its last good byte
  kGpsPower,      ///< power off; comes back with what was saved, or the defaults
  kGpsClockStep,  ///< time tags a second ahead, as with a wrong count of leap seconds
  kGpsNoPps,      ///< no pulses are reported ($PASHR,PTT)
  kPpsLost,       ///< no edges on the pulse line
  kPpsJitter,     ///< their stamps come up to several milliseconds late
  kPpsDouble,     ///< a spurious edge in each second
  kAhrsUnplug,
  kAhrsSilent,
  kAhrsGarbage,
  kAhrsStuck,
  kAhrsClockStep,     ///< its sample counter jumps by 16 ms, and back at the end
  kCameraHang,        ///< connected, but no frames and no answer
  kCameraMiss,        ///< value: share of triggers lost; all of them if nothing is said
  kCameraDouble,      ///< value: share of triggers that make a second exposure soon after
  kCameraLate,        ///< frames come one trigger period late
  kCameraDark,        ///< frames are black
  kCameraDisconnect,  ///< the socket closes; nobody listens until the end of the fault
  kLaser1Unplug,      ///< laser scanners as the serial instruments above
  kLaser1Silent,
  kLaser1Garbage,
  kLaser1Stuck,
  kLaser1Power,
  kLaser2Unplug,
  kLaser2Silent,
  kLaser2Garbage,
  kLaser2Stuck,
  kLaser2Power,
  kRadioDown,   ///< nothing comes through
  kRadioLoss,   ///< value: share of datagrams lost, one by one
  kRadioBurst,  ///< value: share of datagrams lost in fades
  kRadioRate,   ///< value: bits per second at most
  kRadioDelay,  ///< value: seconds on top; last, tests count up to it
};
const char* ToString(FaultKind kind);  ///< as in the option: "gps.unplug"
bool HasValue(FaultKind kind);         ///< "radio.loss=0.3"
/// Of the radio link between robot and base (kawara-sim radio), not of the robot's instruments.
bool IsRadioFault(FaultKind kind);
inline bool IsInstrumentFault(FaultKind kind) { return !IsRadioFault(kind); }

/// One thing that goes wrong, counted from the start of the run.
struct Fault {
  FaultKind kind{};
  core::Duration begin{};
  core::Duration length{};
  double value = 0.0;  ///< how bad, where the kind says what it means
  bool Covers(core::Duration since_start) const {
    return since_start >= begin && since_start < begin + length;
  }
};

/// "gps.unplug, gps.silent, ...": all there are.
std::string AllFaultNames();

/// "t=30 gps.unplug 5s": seconds from the start of the run, what, for how long (default 5 s); the
/// kinds with a value may say it, "t=30 radio.loss=0.3 5s". Several in one text are separated by
/// ';'. Errors: kInvalidArgument, saying what was found and
/// what is possible.
core::Expected<std::vector<Fault>> ParseFaults(std::string_view text);

/// All faults of a run. Immutable after construction; any thread.
class FaultPlan {
 public:
  FaultPlan() = default;
  explicit FaultPlan(std::vector<Fault> faults) : faults_(std::move(faults)) {}
  bool Active(FaultKind kind, core::Duration since_start) const;
  /// Of this kind's active fault, the last one given if there are several; none: not active.
  std::optional<double> Value(FaultKind kind, core::Duration since_start) const;
  const std::vector<Fault>& faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

}  // namespace kawara::sim
