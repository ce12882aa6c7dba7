#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/events.hpp"
#include "core/time.hpp"
#include "drivers/rtcm2.hpp"
#include "drivers/rtcm3.hpp"

namespace kawara::drivers {

struct CorrectionWatchdogConfig {
  core::Duration alarm_age = core::Seconds(5);
  /// A base position older than this no longer counts: bases repeat it every 1 to 60 s.
  core::Duration base_position_max_age = core::Seconds(300);
  double base_moved_m = 0.05;  ///< more than the 1 cm steps of an RTCM 2 message 3
  /// Pseudorange corrections (RTCM 2 types 1, 9, 31, 34) count as usable too; they give metres, not
  /// centimetres.
  bool accept_code_differential = false;
};

enum class CorrectionFormat : std::uint8_t { kRtcm2, kRtcm3, kRaw };
const char* ToString(CorrectionFormat f);  ///< "RTCM2", "RTCM3", "raw"

/// What came of one message type.
struct CorrectionTypeStats {
  CorrectionFormat format = CorrectionFormat::kRtcm3;
  std::uint16_t type = 0;
  std::uint64_t count = 0;
  std::uint64_t bytes = 0;
  core::MonoTime last;
  double interval_s = 0.0;  ///< smoothed over about 8 messages; 0 before the second
};

/// Watches what corrections bring, so that a receiver's "fixed" is not trusted on old data.
/// Usable corrections are observations AND a base position: age() is that of the observations, and
/// endless while no base position is known or it is too old. Alarm "corrections.stale" when the age
/// passes the limit, counted from Start() if nothing ever came, and "corrections.recovered" at the
/// first usable message after it. "corrections.base_moved" when the base's position or station
/// number changes: the track will jump with it. No allocation, no clock of its own: real-time safe
/// and replayable. One thread.
class CorrectionWatchdog {
 public:
  CorrectionWatchdog(const CorrectionWatchdogConfig& config, core::Events& events);

  void Start(core::MonoTime now);
  void OnMessage(core::MonoTime now, const Rtcm3Message& message);
  void OnMessage(core::MonoTime now, const Rtcm2Message& message);
  /// A good message that the receiver can not use: counted, but no help.
  void OnRefused(core::MonoTime now, CorrectionFormat format, std::uint16_t type,
                 std::size_t bytes);
  /// At least once a second.
  void Tick(core::MonoTime now);

  /// Age of the last usable correction by time of arrival. Empty: there is none.
  std::optional<core::Duration> Age(core::MonoTime now) const;
  bool alarm() const { return alarm_; }
  std::uint64_t alarms() const { return alarms_; }

  struct Base {
    std::uint16_t station = 0;
    Eigen::Vector3d ecef_m = Eigen::Vector3d::Zero();
    core::MonoTime last;
  };
  /// The base last heard of, if its position is known.
  const std::optional<Base>& base() const { return base_; }
  std::uint64_t base_moves() const { return base_moves_; }
  /// In order of first appearance. Types beyond 64 share the last entry.
  std::span<const CorrectionTypeStats> types() const { return {types_.data(), types_used_}; }

 private:
  void Count(core::MonoTime now, CorrectionFormat format, std::uint16_t type, std::size_t bytes);
  void OnObservations(core::MonoTime now, bool needs_base);
  void OnBase(core::MonoTime now, std::uint16_t station, const Eigen::Vector3d& ecef_m);
  void NoteUsable(core::MonoTime now);

  const CorrectionWatchdogConfig config_;
  core::Events& events_;
  core::MonoTime started_;
  bool has_observations_ = false;
  bool needs_base_ = true;  ///< of the last observations: code corrections bring their own
  core::MonoTime observations_at_;
  core::MonoTime
      usable_at_;  ///< arrival of the last observations for which a base position was known
  std::optional<Base> base_;
  std::optional<std::uint16_t> coarse_station_;
  Eigen::Vector3d coarse_m_ =
      Eigen::Vector3d::Zero();  ///< RTCM 2 message 3, before 22 made it finer
  bool alarm_ = false;
  core::MonoTime alarm_since_;  ///< of the last usable corrections before the alarm
  std::uint64_t alarms_ = 0;
  std::uint64_t base_moves_ = 0;
  std::array<CorrectionTypeStats, 64> types_{};
  std::size_t types_used_ = 0;
};

}  // namespace kawara::drivers
