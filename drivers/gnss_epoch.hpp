#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/measurements.hpp"
#include "core/time.hpp"
#include "drivers/gnss_clock.hpp"
#include "drivers/gnss_fix.hpp"
#include "drivers/gnss_message.hpp"
#include "drivers/receiver_profile.hpp"

namespace kawara::drivers {

struct GnssEpochConfig {
  ReceiverProfile profile = ReceiverProfile::kNmea;
  /// Rough UTC (within 12 hours) to take the date from until the receiver sends one (RMC, ZDA,
  /// NAV-PVT). Not set: no fix before a date came.
  core::UtcTime reference;
  /// A date before this comes from a receiver that lived through a GPS week roll-over: 1024 weeks
  /// are added until it is not. Not set: dates are believed.
  core::UtcTime not_before;
  /// An epoch that misses a sentence is given out when nothing has come for this long.
  core::Duration timeout = core::Milliseconds(250);
};

class GnssFixSink {
 public:
  virtual ~GnssFixSink() = default;
  virtual void OnFix(const core::GnssFix& fix) = 0;
};

/// Merges the sentences of one epoch of the receiver into one core::GnssFix.
///
/// Sentences belong together by the time of day they carry; those without one (VTG, HDT, LTN) go
/// with the burst they arrive in: with the epoch before them, or with the one after them if they
/// arrive closer to that. The date comes from RMC, ZDA, NAV-PVT or the configuration and is carried
/// over midnight; ZDA is a date only, since some receivers send it a second ahead. PBN, which never
/// is the RTK solution, makes an epoch of its own only when nothing better comes.
///
/// The fix comes out with the last of the sentences that contribute to it: after three bursts it is
/// known which ones do. Until then, and when one of them is lost, it comes with the first sentence
/// of the next epoch, or from Tick().
///
/// Epochs whose time goes backwards, or runs ahead of the arrival stamps, are rejected and counted;
/// after five such in a row, in order among themselves, the receiver's new time line is believed.
///
/// Deterministic: a function of the calls alone. Never throws, never allocates. One thread.
class GnssEpochAssembler {
 public:
  struct Stats {
    std::uint64_t fixes = 0;
    std::uint64_t completed = 0;       ///< of them, given out with their last sentence
    std::uint64_t timed_out = 0;       ///< of them, given out by Tick()
    std::uint64_t late_sentences = 0;  ///< came after their epoch had been given out
    std::uint64_t rejected_times = 0;  ///< sentences whose time went backwards or ran ahead
    std::uint64_t time_steps = 0;      ///< new time lines believed
    std::uint64_t undated = 0;         ///< epochs rejected: no date known
    std::uint64_t rollovers = 0;       ///< dates moved by 1024 weeks
  };

  explicit GnssEpochAssembler(const GnssEpochConfig& config)
      : config_(config), clock_(config.reference, config.not_before) {}

  void OnMessage(const GnssMessage& message, GnssFixSink& sink);
  /// Lets time-outs happen. Call it at 10 Hz or more.
  void Tick(core::MonoTime now, GnssFixSink& sink);
  /// Gives out an epoch begun (end of a recording).
  void Finish(GnssFixSink& sink);

  const Stats& stats() const { return stats_; }

 private:
  /// The sentences that contribute to a fix.
  enum Kind : std::uint8_t { kGga, kRmc, kVtg, kGst, kHeading, kPos, kCbn, kLatency, kPbn, kPvt };
  static constexpr std::size_t kKinds = 10;
  static constexpr unsigned kPrimary = 1U << kGga | 1U << kPos | 1U << kCbn | 1U << kPvt;
  static constexpr unsigned Bit(Kind kind) { return 1U << kind; }

  /// How regular a kind of sentence is.
  struct Habit {
    int present = 0;  ///< epochs in a row with it
    int absent = 0;   ///< epochs in a row without it
    int leading = 0;  ///< untimed ones: > 0 arrives before its epoch's first timed sentence
    bool expected = false;
  };

  template <class T>
  void AddTimed(Kind kind, core::Duration time_of_day, const T& contents,
                std::optional<T> EpochParts::*slot, core::MonoTime arrival, GnssFixSink& sink);
  template <class T>
  void AddUntimed(Kind kind, const T& contents, std::optional<T> EpochParts::*slot,
                  core::MonoTime arrival, GnssFixSink& sink);
  void AddNmea(const NmeaBody& body, core::MonoTime arrival, GnssFixSink& sink);
  void AddAshtech(const AshtechBody& body, core::MonoTime arrival, GnssFixSink& sink);
  void AddPbn(const AshtechPbn& pbn, core::MonoTime arrival, GnssFixSink& sink);
  void AddPvt(const UbxNavPvt& pvt, core::MonoTime arrival, GnssFixSink& sink);

  bool EnterEpoch(core::Duration time_of_day, core::MonoTime arrival, GnssFixSink& sink);
  bool IsNextEpoch(core::Duration time_of_day, core::MonoTime arrival);
  void Seen(Kind kind, GnssFixSink& sink);
  void CloseEpoch(GnssFixSink& sink);
  void Emit(GnssFixSink& sink);
  void Learn();

  GnssEpochConfig config_;
  GnssClock clock_;
  Stats stats_;
  std::array<Habit, kKinds> habits_{};

  bool open_ = false;     ///< an epoch is there: its time of day is key_
  bool emitted_ = false;  ///< it was given out; what still comes of it is late
  core::Duration key_{};
  unsigned seen_ = 0;  ///< bits of Kind
  core::MonoTime first_arrival_;
  EpochParts parts_;
  EpochParts next_;  ///< untimed sentences that came before their epoch
  unsigned next_seen_ = 0;
  core::MonoTime next_arrival_;

  core::MonoTime timed_arrival_;                           ///< of the newest timed sentence
  core::MonoTime newest_arrival_;                          ///< of the newest sentence of any kind
  std::array<core::MonoTime, kKinds> untimed_arrivals_{};  ///< since then; unset: none
  int pbn_alone_ = 0;                                      ///< PBN since anything better came
  int backwards_run_ = 0;  ///< epochs in a row dated before the last fix
  int rejected_run_ = 0;
  core::Duration rejected_key_{};
  core::GpsTime last_time_;
};

}  // namespace kawara::drivers
