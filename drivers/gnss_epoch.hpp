#pragma once
#include <cstdint>

#include "core/measurements.hpp"
#include "core/time.hpp"
#include "drivers/gnss_message.hpp"
#include "drivers/receiver_profile.hpp"

namespace kawara::drivers {

struct GnssEpochConfig {
  ReceiverProfile profile = ReceiverProfile::kNmea;
  /// Rough UTC to take the date from until the receiver sends one (RMC, ZDA). Not set: no fix
  /// before a date came.
  core::UtcTime reference;
  /// A date before this is a receiver that has lived through a GPS week roll-over: 1024 weeks are
  /// added until it is not. Not set: dates are believed.
  core::UtcTime not_before;
  /// An epoch whose last sentence does not come is given out this long after its first one.
  core::Duration timeout = core::Milliseconds(400);
};

class GnssFixSink {
 public:
  virtual ~GnssFixSink() = default;
  virtual void OnFix(const core::GnssFix& fix) = 0;
};

/// Merges the sentences of one epoch of the receiver into one core::GnssFix.
///
/// Sentences belong together by the time of day they carry; those without one (VTG, HDT, LTN) go
/// with the burst they arrive in. The date comes from RMC, ZDA or the configuration and is carried
/// over midnight; ZDA is a date only, since some receivers send it a second ahead. The fix comes
/// out with the last sentence that contributes: after three bursts it is known which ones do. Until
/// then, and when one of them is lost, it comes with the first sentence of the next epoch, or from
/// Tick(). Position and RTK state are taken from CBN, else POS, else GGA, else NAV-PVT, else PBN;
/// the covariance from CBN or GST, else from a table by RTK state (never from HDOP alone). Times
/// that go backwards or repeat are rejected and counted; after five such in a row, in order among
/// themselves, the receiver's new time line is believed.
///
/// Deterministic: a function of the calls alone. Never throws, never allocates. One thread.
class GnssEpochAssembler {
 public:
  struct Stats {
    std::uint64_t fixes = 0;
    std::uint64_t completed = 0;       ///< of them, given out with their last sentence
    std::uint64_t timed_out = 0;       ///< of them, given out by Tick()
    std::uint64_t late_sentences = 0;  ///< came after their epoch had been given out
    std::uint64_t backwards = 0;       ///< epochs rejected: older than or same as the last
    std::uint64_t time_steps = 0;      ///< new time lines believed
    std::uint64_t undated = 0;         ///< epochs rejected: no date known
    std::uint64_t rollovers = 0;       ///< dates moved by 1024 weeks
  };

  explicit GnssEpochAssembler(const GnssEpochConfig& config);

  void OnMessage(const GnssMessage& message, GnssFixSink& sink);
  /// Lets time-outs happen. Call it at 10 Hz or more.
  void Tick(core::MonoTime now, GnssFixSink& sink);
  /// Gives out an epoch begun (end of a recording).
  void Finish(GnssFixSink& sink);

  const Stats& stats() const { return stats_; }

 private:
  GnssEpochConfig config_;
  Stats stats_;
};

}  // namespace kawara::drivers
