#pragma once
#include <array>
#include <cstdint>

#include "core/events.hpp"
#include "core/measurements.hpp"
#include "estimation/gps_timeline.hpp"
#include "onboard/config.hpp"
#include "onboard/core_sink.hpp"
#include "onboard/event_marks.hpp"
#include "onboard/fix_patience.hpp"
#include "onboard/frame_pairing.hpp"
#include "onboard/navigation_chain.hpp"
#include "onboard/shutter_model.hpp"

namespace kawara::onboard {

/// From GNSS epochs to pictures with poses: pulls the trigger, takes the frame that belongs to it,
/// orders the picture, and sends the pose of mid-exposure after it as soon as the fix of its epoch
/// and an attitude after it are in. If the shutter is wired to the receiver's event input, the
/// receiver's time of it takes the place of the camera's stamp. Real-time safe; one thread; a pure
/// function of its calls.
class PictureChain {
 public:
  struct Stats {
    std::int64_t triggers = 0;
    std::int64_t pictures = 0;      ///< frames that became a picture order
    std::int64_t skipped_busy = 0;  ///< frames left out because earlier pictures are not done
    std::int64_t blind_poses = 0;   ///< poses sent without measurements after the exposure
  };

  PictureChain(const CameraConfig& camera, const ScheduleConfig& schedule,
               const estimation::GpsTimeline& timeline, const NavigationChain& navigation,
               core::Events& events, CoreSink& out);

  void OnFix(const core::GnssFix& fix);
  void OnAhrs(const core::AhrsSample& sample) { newest_attitude_ = sample.sampled; }
  void OnFrame(core::MonoTime now, const FrameInput& frame);
  /// The camera exposes frames so long from now on, whatever was configured. Nonsense is ignored.
  void OnShutter(core::Duration length);
  /// The receiver saw the shutter, or its trigger (CameraConfig::event_mark).
  void OnMark(core::GpsTime mark) { marks_.OnMark(mark); }
  void OnPictureDone();
  void RequestPicture() { scheduler_.RequestPicture(); }
  /// The computer's own clock, for the time of pictures while there is no GPS time.
  void OnSystemClock(core::MonoTime mono, core::UtcTime utc);
  void Tick(core::MonoTime now);
  core::MonoTime NextDeadline(core::MonoTime now) const { return scheduler_.NextDeadline(now); }

  const Stats& stats() const { return stats_; }
  const FramePairing::Stats& pairing() const { return pairing_.stats(); }
  const EventMarks::Stats& marks() const { return marks_.stats(); }
  const ShutterModel& shutter() const { return shutter_; }
  std::int64_t skipped_triggers() const { return scheduler_.skipped(); }

  /// Pictures being made at a time; a frame beyond is left out.
  static constexpr int kMaxInFlight = 3;

 private:
  struct Awaiting {
    bool active = false;
    std::int64_t epoch = 0;
    PictureReason reason = PictureReason::kEveryEpochs;
    core::MonoTime exposure;  ///< its middle
    core::MonoTime give_up;
    core::MonoTime fired;
    core::MonoTime stamp;  ///< the camera's own, of the start
    core::Duration half_exposure{};
    bool wants_mark = false;  ///< and has none yet
    core::Duration mark_window{};
  };
  void Fire(core::MonoTime now);
  core::Duration MarkWindow() const;
  void TakeMark(core::MonoTime now, Awaiting& wait);
  void TellOfLead(core::MonoTime now);
  void DoWithoutMark(core::MonoTime now, Awaiting& wait);
  bool WorthWaitingForMark(core::MonoTime now, const Awaiting& wait) const;
  bool IsCovered(core::MonoTime exposure) const;
  void SendPoses(core::MonoTime now);
  void SendPose(const Awaiting& wait, bool covered);

  CameraConfig camera_;
  const estimation::GpsTimeline& timeline_;
  const NavigationChain& navigation_;
  core::Events& events_;
  CoreSink& out_;
  EpochScheduler scheduler_;
  FramePairing pairing_;
  EventMarks marks_;
  ShutterModel shutter_;
  core::Duration half_exposure_;  ///< of the frames that come now
  std::uint32_t trigger_sequence_ = 0;
  std::int64_t epoch_ = 0;
  int in_flight_ = 0;
  std::array<Awaiting, kMaxInFlight> awaiting_{};
  core::GpsTime newest_fix_;
  bool fix_is_new_ = false;
  FixPatience patience_;
  core::MonoTime newest_attitude_;
  core::UtcTime system_utc_;
  core::MonoTime system_mono_;
  double geoid_separation_m_;
  double hdop_;
  Stats stats_;
};

}  // namespace kawara::onboard
