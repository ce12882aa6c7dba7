#include "sim/camera/triggered_camera.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "sim/camera/dark_picture.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kStaleTrigger = core::Milliseconds(100);
constexpr core::Duration kLongestPeriod = core::Seconds(5);
/// A contact that bounces, a line that rings: between the trigger and its second exposure.
constexpr double kSoonestDouble_s = 0.005, kLatestDouble_s = 0.040;

}  // namespace

TriggeredCamera::TriggeredCamera(const SimClock& clock, std::unique_ptr<PictureSource> pictures,
                                 const CameraOptions& options, Hooks hooks)
    : clock_(clock),
      pictures_(std::move(pictures)),
      options_(options),
      hooks_(std::move(hooks)),
      dice_(options.seed) {}

std::vector<TriggeredCamera::Frame> TriggeredCamera::OnTrigger(std::uint32_t sequence,
                                                               core::MonoTime pulse,
                                                               core::MonoTime now,
                                                               const Faults& faults) {
  std::vector<Frame> out;
  ++counters_.triggers;
  pulse = std::min(pulse, now);
  if (Happens(faults.miss) || now - pulse > kStaleTrigger) {
    ++counters_.missed;
    return out;
  }
  period_ = last_trigger_.IsSet() ? pulse - last_trigger_ : core::Duration{};
  last_trigger_ = pulse;
  prepared_ = false;
  // A camera's own electronics cost the robot's computer nothing: the next picture is drawn when
  // the robot has had some time for this one, and early enough to be ready.
  prepare_at_ = pulse + (period_ < kLongestPeriod ? period_ / 4 : core::Duration{});

  std::optional<Frame> frame = Expose(sequence, pulse, faults);
  if (held_back_) out.push_back(*std::exchange(held_back_, std::nullopt));
  if (frame && faults.late) {
    held_back_ = std::move(frame);
  } else if (frame) {
    out.push_back(std::move(*frame));
  }
  if (!Happens(faults.doubled)) return out;
  ++counters_.doubled;
  const double bounce_s = kSoonestDouble_s + (kLatestDouble_s - kSoonestDouble_s) * dice_.Uniform();
  frame = Expose(sequence, pulse + core::DurationFromSeconds(bounce_s), faults);
  if (frame) out.push_back(std::move(*frame));
  return out;
}

/// No chance is spent on what is certain, so that runs without such faults stay as they are.
bool TriggeredCamera::Happens(double share) {
  return share >= 1.0 || (share > 0.0 && dice_.Uniform() < share);
}

std::optional<TriggeredCamera::Frame> TriggeredCamera::Expose(std::uint32_t sequence,
                                                              core::MonoTime pulse,
                                                              const Faults& faults) {
  const double delay_s = options_.exposure_delay_s + options_.exposure_jitter_s * dice_.Normal();
  const core::MonoTime start = pulse + core::DurationFromSeconds(std::max(delay_s, 0.0));
  hooks_.signal(options_.signals_exposure ? start : pulse);
  Exposure exposure{sequence, ++frame_sequence_, start, clock_.GpsAt(start)};
  core::Expected<Picture> picture =
      pictures_->Expose({.trigger_sequence = sequence, .exposure = exposure.gps});
  if (picture && faults.dark) picture = DarkPicture(*picture);
  if (picture && picture->exposed.IsSet()) {
    exposure.gps = picture->exposed;
    exposure.mono = clock_.MonoAt(picture->exposed);
  }
  hooks_.exposed(exposure);
  if (!picture) {
    std::fprintf(stderr, "kawara-sim: %s\n", picture.error().message.c_str());
    ++counters_.spoiled;
    return std::nullopt;
  }
  core::MonoTime stamp = exposure.mono + core::DurationFromSeconds(options_.stamp_late_s);
  if (options_.stamp_jitter_s > 0.0) {
    stamp += core::DurationFromSeconds(options_.stamp_jitter_s * dice_.Normal());
  }
  Frame frame;
  frame.header.sequence = exposure.frame_sequence;
  frame.header.trigger_sequence = options_.names_trigger ? sequence : 0;
  frame.header.exposure_start_mono_ns = stamp.ns();
  frame.header.width = picture->width;
  frame.header.height = picture->height;
  frame.header.payload_bytes = static_cast<std::uint32_t>(picture->jpeg.size());
  frame.picture = std::move(*picture);
  frame.ready = start + core::DurationFromSeconds(options_.readout_s);
  return frame;
}

void TriggeredCamera::Prepare(core::MonoTime now) {
  prepared_ = true;
  const bool regular = period_.count() > 0 && period_ < kLongestPeriod;
  const core::MonoTime expected = regular ? last_trigger_ + period_ : now;
  pictures_->Prepare(clock_.GpsAt(expected + core::DurationFromSeconds(options_.exposure_delay_s)));
}

}  // namespace kawara::sim
