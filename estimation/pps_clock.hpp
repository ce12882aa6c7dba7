#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/time.hpp"
#include "estimation/clock_types.hpp"

namespace kawara::estimation {

struct PpsConfig {
  double pulse_sigma_s =
      20e-6;  ///< of one stamp as taken (kernel PPS 5e-6, GPIO 20e-6, polled modem line 1e-3)
  double pulse_latency_s =
      0.0;  ///< known mean from the edge to its stamp, and its systematic uncertainty
  double pulse_latency_sigma_s = 5e-6;
  double skew_sigma_ppm = 50.0;   ///< before anything is measured
  double skew_wander_ppm = 0.01;  ///< per root second; rules how sigma grows in hold-over
  double outlier_floor_s = 1e-3;  ///< residuals below this are never outliers
  int confirm_labels = 5;         ///< labels in a row that must agree before a second is believed
  int confirm_steps =
      5;  ///< pulses in a row that must agree before the phase is believed to have moved
  core::Duration holdover_after = core::Milliseconds(3500);  ///< three pulses missed
  double max_sigma_s =
      0.05;  ///< hold-over worse than this: the second is no longer certain, lock is lost
};

/// GPS time from the receiver's pulses (one at each full GPS second). A pulse gives the phase only;
/// which second it is comes from labels: the receiver's messages. The rule is: labelled right or
/// not at all. The clock locks when `confirm_labels` labels in a row agree on pulses that come one
/// a second, refuses pulses far from its prediction (outliers, doubles), carries on over missing
/// pulses with growing sigma, and unlocks when labels contradict it `confirm_labels` times in a
/// row.
///
/// Inside: a two-state Kalman filter (offset, skew) whose measurement noise follows the scatter it
/// sees, so that jittery stamps (USB) neither lock it out nor make it over-confident.
///
/// Real-time safe, deterministic, O(1). One thread. Reads no clock.
class PpsClock {
 public:
  enum class Result {
    kUsed,        ///< moved the clock
    kUnlabelled,  ///< no certain second yet
    kDouble,      ///< second pulse in one second
    kOutlier,
    kStepped,  ///< the pulses' phase has moved; followed, counted
  };

  explicit PpsClock(const PpsConfig& config = {}) : config_(config) {}

  /// A pulse with its stamp. `label` is the GPS second it marks, if the caller can tell for
  /// certain.
  Result AddPulse(core::MonoTime edge, std::optional<core::GpsTime> label);
  /// A message that names the second of the pulse just before it (PTT), arriving at `arrival`. Used
  /// only if exactly one pulse lies within the half second before.
  void AddLabel(core::GpsTime second, core::MonoTime arrival);

  bool locked() const { return locked_; }
  /// Meaningful only while locked().
  Aligned<core::MonoTime> ToMono(core::GpsTime t) const;
  Aligned<core::GpsTime> ToGps(core::MonoTime t) const;
  ClockStatus Status(core::MonoTime now) const;
  core::MonoTime last_pulse() const { return last_pulse_; }
  std::int64_t label_conflicts() const { return label_conflicts_; }
  std::int64_t doubles() const { return doubles_; }

 private:
  void Vote(core::MonoTime edge, core::GpsTime label);
  void Lock(core::MonoTime edge, core::GpsTime second);
  void Unlock();
  Result Track(core::MonoTime edge);
  Result Refuse(core::MonoTime edge, double residual);
  /// Covariance of (offset, skew) carried dt seconds on.
  struct Covariance {
    double oo = 0.0, os = 0.0, ss = 0.0;
  };
  Covariance Propagated(double dt_s) const;
  double SigmaAt(double dt_s) const;

  const PpsConfig config_;
  bool locked_ = false;
  core::GpsTime ref_gps_;    ///< the second of the last pulse used
  core::MonoTime ref_mono_;  ///< where the filter says it was
  double skew_ = 0.0;        ///< d mono / d gps - 1
  Covariance cov_;
  double scatter_s2_ = 0.0;  ///< smoothed square of the innovations

  core::MonoTime last_pulse_;  ///< last one used
  core::MonoTime last_edge_;   ///< last one seen
  core::MonoTime before_last_edge_;
  int used_since_lock_ = 0;  ///< up to 16
  int refused_in_row_ = 0;
  double refused_residual_s_ = 0.0;

  int votes_ = 0;  ///< unlocked: labels in a row that agree; locked: in a row that contradict
  std::int64_t vote_offset_ns_ = 0;  ///< edge - label of the last vote

  std::int64_t steps_ = 0;
  std::int64_t outliers_ = 0;
  std::int64_t doubles_ = 0;
  std::int64_t label_conflicts_ = 0;
};

}  // namespace kawara::estimation
