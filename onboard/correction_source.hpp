#pragma once
#include <atomic>
#include <thread>

#include "core/measurements.hpp"
#include "core/spsc_ring.hpp"
#include "drivers/ntrip_client.hpp"
#include "onboard/config.hpp"
#include "onboard/input_inbox.hpp"

namespace kawara::onboard {

/// Of corrections with `source: ntrip`.
drivers::NtripClientConfig NtripConfigOf(const CorrectionsConfig& config);

/// The corrections thread: fetches RTCM from an NTRIP caster or a serial radio and puts the bytes
/// into the core's inbox. (Corrections over LCM come in through the pump.) Resolving names and
/// connecting may block for seconds: here that hurts nobody.
class CorrectionSource {
 public:
  CorrectionSource(const CorrectionsConfig& config, InputInbox& inbox);
  ~CorrectionSource();  ///< Stop()
  CorrectionSource(const CorrectionSource&) = delete;
  CorrectionSource& operator=(const CorrectionSource&) = delete;

  /// Newest fix, for the position upload of network RTK. One thread (the pump).
  void OnFix(const core::GnssFix& fix) { fixes_.PushDroppingOldest(fix); }
  void Stop();

 private:
  void RunNtrip();
  void RunSerial();
  void Post(core::MonoTime now, std::span<const std::uint8_t> bytes);
  void TellEvents(core::Events& events);

  CorrectionsConfig config_;
  InputInbox& inbox_;
  core::SpscRing<core::GnssFix, 4> fixes_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kawara::onboard
