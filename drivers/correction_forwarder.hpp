#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/events.hpp"
#include "core/time.hpp"
#include "drivers/correction_queue.hpp"
#include "drivers/correction_watchdog.hpp"
#include "drivers/rtcm2_decoder.hpp"
#include "drivers/rtcm2_encoder.hpp"
#include "drivers/rtcm3.hpp"

namespace kawara::drivers {

enum class CorrectionMode : std::uint8_t {
  kMessages,  ///< only whole RTCM 3 frames with the right CRC and whole RTCM 2 messages
  kRaw,       ///< bytes as they come (CMR, DBEN, ...); still looked into for the watchdog
};
enum class CorrectionsAccepted : std::uint8_t {
  kAny,
  kRtcm2Only,  ///< Z-Family: firmware of before 2004
  kRtcm3Only,
};

struct CorrectionForwarderConfig {
  CorrectionMode mode = CorrectionMode::kMessages;
  CorrectionsAccepted receiver_accepts = CorrectionsAccepted::kAny;
  CorrectionWatchdogConfig watchdog;
};

/// Between the sources of corrections (NTRIP, radio, LCM) and the receiver's port. Bytes of any
/// split go in; whole messages come out, never half of one with something else in between:
///     forwarder.Feed(now, bytes);
///     forwarder.Consume(port.Write(forwarder.Output()).value_or(0));   // until Output() is empty
///     or takes nothing
/// While the receiver is being configured (Hold) nothing comes out beyond a message begun, because
/// corrections in the middle of a dialogue can hang a receiver; up to 64 messages wait, the oldest
/// give way and are counted. Receivers that take RTCM 2 only are not sent RTCM 3 frames;
/// "corrections.wrong_format" says so, with the cure. RTCM 2 messages are written anew from their
/// words: byte-aligned and with a parity chain of their own, so that a receiver can read them
/// whatever lay between them in the source. One source at a time: two streams mixed would damage
/// each other's frames; call Restart() when the source changes. No allocation, no clock of its own:
/// real-time safe and replayable. One thread.
class CorrectionForwarder {
 public:
  struct Stats {
    std::uint64_t bytes_in = 0;
    std::uint64_t messages = 0;   ///< good ones seen
    std::uint64_t forwarded = 0;  ///< put into the queue
    std::uint64_t bytes_out = 0;
    std::uint64_t refused = 0;        ///< good, but the receiver does not take this format
    std::uint64_t bad_crc = 0;        ///< RTCM 3 preambles without a frame
    std::uint64_t parity_errors = 0;  ///< RTCM 2
    std::uint64_t dropped = 0;        ///< queue full: receiver held too long or port too slow
  };

  CorrectionForwarder(const CorrectionForwarderConfig& config, core::Events& events);

  void Feed(core::MonoTime now, std::span<const std::uint8_t> bytes);
  /// At least once a second, also when nothing comes.
  void Tick(core::MonoTime now);
  void Start(core::MonoTime now) { watchdog_.Start(now); }

  void Hold();
  void Release();
  bool held() const { return held_; }
  /// The source changed or had a gap: a frame begun is forgotten.
  void Restart();

  /// Bytes that may go out now: the rest of one message. Valid until the next call of any other
  /// method.
  std::span<const std::uint8_t> Output() const;
  void Consume(std::size_t bytes);

  const CorrectionWatchdog& watchdog() const { return watchdog_; }
  Stats stats() const;

 private:
  void OnRtcm3(core::MonoTime now, std::span<const std::uint8_t> frame);
  void OnRtcm2(core::MonoTime now, const Rtcm2Message& message);
  void Push(core::MonoTime now, std::span<const std::uint8_t> message);
  void Refuse(core::MonoTime now, CorrectionFormat format, std::uint16_t type, std::size_t bytes);

  const CorrectionForwarderConfig config_;
  core::Events& events_;
  Rtcm3Framer rtcm3_;
  Rtcm2Decoder rtcm2_;
  CorrectionWatchdog watchdog_;
  CorrectionQueue queue_;
  bool held_ = false;
  Rtcm2Encoder rtcm2_out_;
  Stats stats_;
};

}  // namespace kawara::drivers
