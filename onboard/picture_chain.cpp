#include "onboard/picture_chain.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

namespace kawara::onboard {
namespace {

/// An exposure so little after the newest fix needs no later one: velocity carries it on within
/// millimetres.
constexpr core::Duration kSameEpoch = core::Milliseconds(30);

/// A mark leaves the receiver within so much of its pulse (Z-Family manual p.200: at once; the port
/// may be busy with an epoch's sentences).
constexpr core::Duration kMarkPatience = core::Milliseconds(200);
/// The configured lead is worth a word if it is off by more than that.
constexpr core::Duration kLeadTolerance = core::Milliseconds(2);

/// Longer than any camera of a robot that drives exposes.
constexpr core::Duration kLongestExposure = core::Seconds(1);

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

void PictureChain::OnShutter(core::Duration length) {
  if (length.count() > 0 && length <= kLongestExposure) half_exposure_ = length / 2;
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
  *free = {.active = true,
           .epoch = epoch_,
           .reason = exposure->plan.reason,
           .exposure = middle,
           .give_up = middle + patience_.Get(),
           .fired = exposure->fired,
           .stamp = frame.exposure_start,
           .half_exposure = half_exposure_,
           .wants_mark = camera_.event_mark != "none",
           .mark_window = MarkWindow()};
  SendPoses(now);
}

/// Never so wide that the mark of the epoch before or after is within it.
core::Duration PictureChain::MarkWindow() const {
  core::Duration window = core::DurationFromSeconds(camera_.pairing_window_s);
  if (scheduler_.epoch_period().count() > 0) {
    window = std::min(window, scheduler_.epoch_period() / 2);
  }
  if (camera_.RunsFreely()) {
    window = std::min(window, core::DurationFromSeconds(0.5 / camera_.v4l2.rate_hz));
  }
  return window;
}

/// Looks for the mark of an exposure, by where it must be from the trigger; from the camera's stamp
/// if there is no trigger.
void PictureChain::TakeMark(core::MonoTime now, Awaiting& wait) {
  if (!wait.wants_mark || !timeline_.valid()) return;
  const core::Duration lead = core::DurationFromSeconds(camera_.trigger_lead_s);
  const bool of_trigger = camera_.event_mark == "trigger";
  core::MonoTime expected = wait.stamp;
  if (!camera_.RunsFreely()) expected = of_trigger ? wait.fired : wait.fired + lead;
  const auto mark = marks_.Take(timeline_.ToGps(expected).time, wait.mark_window);
  if (!mark) return;
  wait.wants_mark = false;
  const core::MonoTime seen = timeline_.ToMono(*mark).time;
  const core::MonoTime start = of_trigger ? seen + lead : seen;
  wait.exposure = start + wait.half_exposure;
  shutter_.Learn(wait.fired, wait.stamp, start);
  if (shutter_.seen() == ShutterModel::kEnough) TellOfLead(now);
}

/// Once, when the camera is known.
void PictureChain::TellOfLead(core::MonoTime now) {
  const bool measurable = camera_.event_mark == "exposure" && !camera_.RunsFreely();
  const core::Duration lead = shutter_.lead().mean;
  const core::Duration off = lead - core::DurationFromSeconds(camera_.trigger_lead_s);
  if (!measurable || std::chrono::abs(off) < kLeadTolerance) return;
  core::EventText text("exposures start ");
  text.Append(core::ToSeconds(lead) * 1e3, 1)
      .Append(" ms after the trigger: with camera.trigger_lead_s: ")
      .Append(core::ToSeconds(lead), 4)
      .Append(" they would lie on the receiver's epochs");
  events_.WarnLow(now, "camera.lead", text);
}

void PictureChain::DoWithoutMark(core::MonoTime now, Awaiting& wait) {
  if (!wait.wants_mark || !timeline_.valid()) return;
  if (const auto start = shutter_.StartOf(wait.fired, wait.stamp)) {
    wait.exposure = *start + wait.half_exposure;
  }
  if (!marks_.Miss()) return;
  events_.WarnHigh(now, "camera.no_mark",
                   "the receiver's event input sees no shutter (wire, edge, option E of the "
                   "receiver?): pictures are dated without it");
}

bool PictureChain::WorthWaitingForMark(core::MonoTime now, const Awaiting& wait) const {
  return wait.wants_mark && marks_.alive() && now < wait.exposure + kMarkPatience;
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
    TakeMark(now, wait);
    const bool covered = IsCovered(wait.exposure);
    if (!covered && now < wait.give_up) continue;
    if (WorthWaitingForMark(now, wait)) continue;
    DoWithoutMark(now, wait);
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
