#include "onboard/picture_chain.hpp"

#include <limits>
#include <utility>

namespace kawara::onboard {
namespace {

/// An exposure so little after the newest fix needs no later one: velocity carries it on within
/// millimetres.
constexpr core::Duration kSameEpoch = core::Milliseconds(30);

/// Stamps of frames scatter by so much.
constexpr core::Duration kStampScatter = core::Milliseconds(3);

/// A camera that runs freely takes its picture up to half a period before the trigger or after it.
/// One before it may be here already when the trigger comes, and cannot be had any more: then it is
/// the next, less than a period after the trigger.
FramePairing PairingFor(const CameraConfig& camera) {
  if (!camera.RunsFreely()) {
    return {core::DurationFromSeconds(camera.trigger_lead_s),
            core::DurationFromSeconds(camera.pairing_window_s)};
  }
  const core::Duration period = core::DurationFromSeconds(1.0 / camera.v4l2.rate_hz);
  return {core::Duration(0), period / 2 + kStampScatter, period + kStampScatter};
}

}  // namespace

PictureChain::PictureChain(const CameraConfig& camera, const ScheduleConfig& schedule,
                           const estimation::GpsTimeline& timeline,
                           const NavigationChain& navigation, core::Events& events, CoreSink& out)
    : camera_(camera),
      timeline_(timeline),
      navigation_(navigation),
      events_(events),
      out_(out),
      scheduler_(schedule),
      pairing_(PairingFor(camera)),
      half_exposure_(core::DurationFromSeconds(camera.exposure_s / 2)),
      geoid_separation_m_(std::numeric_limits<double>::quiet_NaN()),
      hdop_(std::numeric_limits<double>::quiet_NaN()) {}

void PictureChain::OnFix(const core::GnssFix& fix) {
  scheduler_.OnFix(fix.time, fix.has_position ? &fix.antenna : nullptr);
  newest_fix_ = fix.time;
  fix_is_new_ = true;
  geoid_separation_m_ = fix.geoid_separation_m;
  hdop_ = fix.hdop;
}

void PictureChain::OnSystemClock(core::MonoTime mono, core::UtcTime utc) {
  system_mono_ = mono;
  system_utc_ = utc;
}

void PictureChain::Tick(core::MonoTime now) {
  if (camera_.source == "none") return;
  if (std::exchange(fix_is_new_, false) && timeline_.valid()) {
    patience_.Add(now - timeline_.ToMono(newest_fix_).time);
  }
  Fire(now);
  if (pairing_.Expire(now) > 0) {
    events_.WarnHigh(now, "camera.no_frame", "the camera was triggered, but no frame came");
  }
  SendPoses(now);
}

void PictureChain::Fire(core::MonoTime now) {
  const auto due = scheduler_.Due(now, timeline_);
  if (!due) return;
  ++stats_.triggers;
  ++trigger_sequence_;
  out_.Trigger(trigger_sequence_);
  pairing_.OnTrigger({trigger_sequence_, *due, now});
}

void PictureChain::OnFrame(core::MonoTime now, const FrameInput& frame) {
  const auto exposure = pairing_.OnFrame(frame);
  Awaiting* free = nullptr;
  for (Awaiting& wait : awaiting_) {
    if (!wait.active) free = &wait;
  }
  const bool busy = in_flight_ >= kMaxInFlight || free == nullptr;
  const bool selected = exposure.has_value() && !busy;
  out_.OnFrame(frame, selected);
  if (!exposure) {
    if (camera_.RunsFreely()) return;  // most frames are between triggers
    events_.WarnLow(now, "camera.stray_frame", "a frame came that no trigger was waiting for");
    return;
  }
  if (busy) {
    ++stats_.skipped_busy;
    events_.WarnHigh(now, "phase1.busy",
                     "pictures are ordered faster than this computer makes them: one is left out");
    return;
  }
  ++stats_.pictures;
  ++in_flight_;
  ++epoch_;
  out_.OnPicture({epoch_, frame.slot});
  const core::MonoTime middle = frame.exposure_start + half_exposure_;
  *free = {true, epoch_, exposure->plan.reason, middle, middle + patience_.Get()};
  SendPoses(now);
}

void PictureChain::OnPictureDone() {
  if (in_flight_ > 0) --in_flight_;
}

bool PictureChain::IsCovered(core::MonoTime exposure) const {
  return timeline_.valid() && newest_attitude_ >= exposure &&
         newest_fix_ + kSameEpoch >= timeline_.ToGps(exposure).time;
}

void PictureChain::SendPoses(core::MonoTime now) {
  for (Awaiting& wait : awaiting_) {
    if (!wait.active) continue;
    const bool covered = IsCovered(wait.exposure);
    if (!covered && now < wait.give_up) continue;
    SendPose(wait, covered);
    wait.active = false;
  }
}

void PictureChain::SendPose(const Awaiting& wait, bool covered) {
  if (!covered) ++stats_.blind_poses;
  ExposurePose pose;
  pose.epoch = wait.epoch;
  pose.reason = wait.reason;
  pose.body = navigation_.At(wait.exposure);
  if (!pose.body.time.IsSet() && system_utc_.IsSet()) {
    // No GPS time yet: better the computer's clock than none. The pose says that it is not valid.
    pose.body.time = core::ToGps(system_utc_ + (wait.exposure - system_mono_));
    pose.body.valid = false;
  }
  pose.camera = pose.body;
  const Eigen::Matrix3d R_ned_body = core::RotationNedFromBody(pose.body.attitude);
  pose.camera.position = core::OffsetNed(pose.body.position, R_ned_body * camera_.position_frd_m);
  pose.gps_minus_utc_s = core::LeapSeconds().OffsetAt(pose.body.time);
  pose.geoid_separation_m = geoid_separation_m_;
  pose.hdop = hdop_;
  out_.OnExposurePose(pose);
}

}  // namespace kawara::onboard
