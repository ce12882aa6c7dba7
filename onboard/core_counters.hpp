#pragma once
#include "core/counters.hpp"
#include "drivers/ahrs400.hpp"
#include "drivers/correction_forwarder.hpp"
#include "drivers/gnss_epoch.hpp"
#include "drivers/gnss_stream.hpp"
#include "estimation/navigation_report.hpp"
#include "estimation/navigation_stats.hpp"
#include "onboard/picture_chain.hpp"
#include "onboard/pulse_chain.hpp"

namespace kawara::onboard {

/// The named counters of the robot's core: what the parts count is copied here once a second.
/// Construction allocates; the Set calls are real-time safe.
class CoreCounters {
 public:
  explicit CoreCounters(core::Counters& counters);

  void Set(const drivers::GnssStreamDecoder::Stats& stream,
           const drivers::GnssEpochAssembler::Stats& epochs);
  void Set(const drivers::Ahrs400Stats& ahrs);
  void Set(const drivers::CorrectionForwarder::Stats& corrections);
  void Set(const PulseChain::Stats& pulses);
  void Set(const PictureChain& pictures);
  void Set(const estimation::NavigationReport& report,
           const estimation::NavigationStats& navigation);

 private:
  core::Counter &gps_good_, &gps_bad_checksum_, &gps_skipped_bytes_, &gps_fixes_, &gps_timed_out_,
      &gps_rejected_times_, &gps_undated_;
  core::Counter &ahrs_good_, &ahrs_bad_checksum_, &ahrs_skipped_bytes_, &ahrs_frozen_;
  core::Counter &pulses_used_, &pulses_refused_, &pulses_missing_;
  core::Counter &rtcm_forwarded_, &rtcm_bad_, &rtcm_refused_, &rtcm_dropped_;
  core::Counter &triggers_, &triggers_skipped_, &paired_, &missed_, &stray_, &doubled_, &disagreed_,
      &marked_, &mark_missing_, &mark_stray_, &lead_, &stamp_error_, &pictures_, &busy_, &blind_;
  core::Counter &nav_fixes_used_, &nav_fixes_refused_, &nav_wrong_fixes_, &nav_resets_,
      &nav_outages_, &nav_late_, &nav_too_late_, &nav_imu_refused_;
};

}  // namespace kawara::onboard
