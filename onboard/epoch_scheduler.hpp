#pragma once
#include <cstdint>
#include <optional>

#include "core/geodesy.hpp"
#include "core/measurements.hpp"
#include "core/time.hpp"
#include "estimation/gps_timeline.hpp"

namespace kawara::onboard {

using core::PictureReason;

struct ScheduleConfig {
  int every_epochs = 4;  ///< a picture every so many GNSS epochs; 0 = off
  double every_m = 0.0;  ///< and whenever the robot has gone so far [m]; 0 = off
  double trigger_lead_s =
      0.0;  ///< from Trigger() to the start of exposure: fires this much earlier (< 0: later)
  double free_run_period_s = 1.0;  ///< while there is no GPS time at all
  double free_run_after_s = 5.0;   ///< ... for so long
};

struct PlannedExposure {
  core::GpsTime epoch;     ///< the GNSS epoch it belongs to; not set when free-running
  core::MonoTime fire_at;  ///< when to pull the trigger
  PictureReason reason = PictureReason::kEveryEpochs;
};

/// Decides which GNSS epochs get a picture and when the trigger must be pulled for each.
///
/// Exposures lie on the receiver's own epochs (their period and phase are learnt from the fixes,
/// e.g. 4 Hz at x.249, x.499, ...), so that the RTK solution of that very epoch is the picture's
/// position (paper, section 3: "in synchronization with the position, posture, and time data").
/// Epochs are predicted from the GPS time line, so that pictures go on while the receiver is
/// silent. Without any GPS time the camera runs free on the monotonic clock: the headquarters still
/// sees, and the packet says that the pose is not valid.
///
/// Real-time safe; one thread; a pure function of its calls.
class EpochScheduler {
 public:
  explicit EpochScheduler(const ScheduleConfig& config);

  /// A new fix: learns the epochs, measures the distance gone.
  void OnFix(core::GpsTime epoch, const core::Geodetic* position);
  /// Take one at the next epoch, whatever the rule says.
  void RequestPicture() { requested_ = true; }

  /// The exposure to fire at or before `now`, at most one a call. Each is returned once; one that
  /// could not be fired within kTooLate is skipped and counted.
  std::optional<PlannedExposure> Due(core::MonoTime now, const estimation::GpsTimeline& timeline);
  /// When Due() wants to be called again at the latest.
  core::MonoTime NextDeadline(core::MonoTime now) const;

  core::Duration epoch_period() const { return period_; }
  std::int64_t skipped() const { return skipped_; }

  static constexpr core::Duration kTooLate = core::Milliseconds(30);

 private:
  void Plan(core::MonoTime now, const estimation::GpsTimeline& timeline);
  void CountPassed(core::GpsTime next);
  void PlanFreeRunning(core::MonoTime now);
  std::optional<PictureReason> WantedAt(std::int64_t epoch_index) const;

  ScheduleConfig config_;
  core::Duration period_{};     ///< 0: not learnt yet
  core::Duration candidate_{};  ///< last difference between fixes
  int candidate_count_ = 0;
  core::GpsTime last_fix_;
  core::GpsTime last_planned_;  ///< epoch of the newest exposure planned
  core::MonoTime last_fired_;
  core::MonoTime first_call_;
  std::optional<PlannedExposure> next_;
  std::optional<core::Geodetic> last_position_;
  double gone_m_ = 0.0;
  bool requested_ = false;
  std::int64_t skipped_ = 0;
};

}  // namespace kawara::onboard
