#include "drivers/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "drivers/motion_jpeg.hpp"
#include "drivers/v4l2_pixels.hpp"

namespace kawara::drivers {
namespace {

/// A slow camera hangs only after so many of its own periods.
constexpr int kHangPeriods = 4;

std::string SecondsText(core::Duration duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", core::ToSeconds(duration));
  return text;
}

}  // namespace

struct V4l2Camera::Tally {
  explicit Tally(core::Counters& counters)
      : opened(counters.Register("camera.v4l2.opened")),
        open_failures(counters.Register("camera.v4l2.open_failures")),
        lost(counters.Register("camera.v4l2.lost")),
        restarts(counters.Register("camera.v4l2.restarts")),
        sequence_gaps(counters.Register("camera.v4l2.sequence_gaps")),
        error_frames(counters.Register("camera.v4l2.error_frames")),
        damaged_frames(counters.Register("camera.v4l2.damaged_frames")),
        foreign_stamps(counters.Register("camera.v4l2.foreign_stamps")),
        trigger_failures(counters.Register("camera.v4l2.trigger_failures")) {}

  core::Counter& opened;
  core::Counter& open_failures;
  core::Counter& lost;
  core::Counter& restarts;
  core::Counter& sequence_gaps;
  core::Counter& error_frames;
  core::Counter& damaged_frames;
  core::Counter& foreign_stamps;
  core::Counter& trigger_failures;
};

V4l2Camera::V4l2Camera(V4l2CameraConfig config, core::Counters& counters)
    : V4l2Camera(std::move(config), counters, System{}) {}

V4l2Camera::V4l2Camera(V4l2CameraConfig config, core::Counters& counters, System system)
    : config_(std::move(config)),
      tally_(std::make_unique<Tally>(counters)),
      now_(std::move(system.now)),
      finder_(config_.device, std::move(system.open), std::move(system.nodes)),
      open_line_(std::move(system.open_line)) {
  if (config_.IsTriggered()) {
    trigger_ = std::make_unique<V4l2TriggerThread>([this] { PullTrigger(); });
  }
}

V4l2Camera::~V4l2Camera() { trigger_.reset(); }

core::Expected<void> V4l2Camera::Trigger(std::uint32_t /*sequence*/) {
  if (!open_.load(std::memory_order_acquire)) {
    if (trigger_) tally_->trigger_failures.Add();
    return tl::unexpected(core::Error{core::ErrorCode::kUnavailable, {}});
  }
  if (trigger_) {
    std::int64_t none = 0;
    unanswered_ns_.compare_exchange_strong(none, now_().ns());
    unanswered_.fetch_add(1);
    trigger_->Fire();
  }
  return {};
}

void V4l2Camera::PullTrigger() {
  const bool by_line = config_.trigger_line.kind != TriggerLineConfig::Kind::kNone;
  auto pulled = by_line ? PullLine() : PullControl();
  if (!pulled) tally_->trigger_failures.Add();
  const std::lock_guard lock(session_mutex_);
  trigger_trouble_ = pulled ? std::nullopt : std::optional(std::move(pulled.error()));
}

core::Expected<void> V4l2Camera::PullControl() {
  const std::lock_guard lock(session_mutex_);
  if (!session_) return core::Fail(core::ErrorCode::kUnavailable, "camera: not open");
  return session_->controls().Set(config_.trigger_control, "1");
}

core::Expected<void> V4l2Camera::PullLine() {
  if (!line_) {
    auto line = open_line_(config_.trigger_line);
    if (!line) return tl::unexpected(line.error());
    line_ = std::move(*line);
  }
  auto pulled = line_->Pulse(config_.trigger_line.pulse);
  if (!pulled) line_.reset();
  return pulled;
}

/// What may be wrong when triggers go out and nothing has ever come back.
std::string V4l2Camera::UnansweredText() const {
  const int triggers = unanswered_.load();
  if (!trigger_ || answered_ || triggers == 0) return {};
  return " after " + std::to_string(triggers) +
         " triggers, and none before: its trigger mode, the cable, the polarity "
         "(camera.v4l2.trigger.active_low)?";
}

core::Expected<void> V4l2Camera::Set(const V4l2Settings& settings) {
  if (!session_) return core::Fail(core::ErrorCode::kUnavailable, "camera: not open");
  auto set = session_->controls().Set(settings);
  const core::Duration length = session_->Exposure().value_or(config_.stamps.exposure);
  if (length != rule_.exposure) next_exposure_ = {now_(), length};
  return set;
}

core::Expected<void> V4l2Camera::Open() {
  auto opened = V4l2Session::Open(finder_, config_);
  if (!opened) {
    tally_->open_failures.Add();
    return tl::unexpected(opened.error());
  }
  {
    const std::lock_guard lock(session_mutex_);
    session_ = std::move(*opened);
  }
  tally_->opened.Add();
  stamps_.Reset();
  rule_ = config_.stamps;
  rule_.exposure = session_->Exposure().value_or(config_.stamps.exposure);
  next_exposure_.reset();
  description_ = session_->Description();
  last_sequence_.reset();
  last_life_ = now_();
  unanswered_ns_.store(0);
  unanswered_.store(0);
  answered_ = false;
  hang_ = config_.hang;
  if (const V4l2Interval interval = session_->interval(); interval.known()) {
    hang_ = hang_.count() == 0
                ? hang_
                : std::max(hang_, core::DurationFromSeconds(kHangPeriods / interval.rate_hz()));
  }
  open_.store(true, std::memory_order_release);
  return {};
}

tl::unexpected<core::Error> V4l2Camera::Lose(core::Error why) {
  open_.store(false, std::memory_order_release);
  next_try_ = now_() + config_.reconnect;
  {
    const std::lock_guard lock(session_mutex_);
    session_.reset();
  }
  tally_->lost.Add();
  restarted_ = false;
  trouble_ = why;
  return tl::unexpected(std::move(why));
}

core::MonoTime V4l2Camera::SilentSince() const {
  if (!trigger_) return last_life_;
  const std::int64_t trigger_ns = unanswered_ns_.load();
  return std::max(last_life_, core::MonoTime::FromNs(trigger_ns));
}

bool V4l2Camera::IsSilent(core::MonoTime now) const {
  if (hang_.count() == 0) return false;
  if (trigger_ && unanswered_ns_.load() == 0) return false;  // nothing was asked of it
  return now - SilentSince() >= hang_;
}

V4l2Camera::Answer V4l2Camera::Hang(core::Duration silence) {
  const std::string what = "camera " + session_->device().path() + ": no usable frame for " +
                           SecondsText(silence) + UnansweredText();
  tally_->restarts.Add();
  if (restarted_) {
    return Lose(
        {core::ErrorCode::kUnavailable, what + " after its stream was restarted: reopened"});
  }
  if (auto restart = session_->stream().Restart(); !restart) return Lose(restart.error());
  restarted_ = true;
  last_life_ = now_();
  unanswered_ns_.store(0);
  last_sequence_.reset();
  trouble_ = core::Error{core::ErrorCode::kUnavailable, what + ": its stream was restarted"};
  return tl::unexpected(*trouble_);
}

V4l2Camera::Answer V4l2Camera::Next(core::Duration timeout) {
  if (!session_) {
    if (trouble_ && next_try_.IsSet() && now_() < next_try_) {
      return tl::unexpected(*trouble_);
    }
    if (auto opened = Open(); !opened) {
      trouble_ = opened.error();
      next_try_ = now_() + config_.reconnect;
      return tl::unexpected(opened.error());
    }
  }
  const core::MonoTime deadline = now_() + timeout;
  for (;;) {
    const core::MonoTime now = now_();
    if (IsSilent(now)) return Hang(now - SilentSince());
    V4l2Loan loan;
    const auto got =
        session_->stream().Take(std::clamp(deadline - now, core::Duration(0), timeout), loan);
    if (!got) return Lose(got.error());
    if (*got == V4l2Stream::Got::kFrame) {
      auto frame = Receive(loan);
      if (!frame) return Lose(frame.error());
      if (*frame) return std::shared_ptr<const Frame>(std::move(*frame));
    }
    if (now_() < deadline) continue;
    // A camera that was restarted is not back before its first frame.
    if (restarted_) return tl::unexpected(*trouble_);
    if (const std::lock_guard lock(session_mutex_); trigger_trouble_) {
      return tl::unexpected(*trigger_trouble_);
    }
    return std::shared_ptr<const Frame>();
  }
}

void V4l2Camera::CountGap(std::uint32_t sequence) {
  if (last_sequence_) {
    const std::uint32_t lost = sequence - *last_sequence_ - 1;  // across the wrap as well
    if (lost < (1U << 31)) tally_->sequence_gaps.Add(lost);
  }
  last_sequence_ = sequence;
}

core::Expected<std::shared_ptr<Frame>> V4l2Camera::Receive(const V4l2Loan& loan) {
  const bool marked = (loan.flags & V4L2_BUF_FLAG_ERROR) != 0;
  if (!marked) copy_.assign(loan.bytes.begin(), loan.bytes.end());
  if (auto given = session_->stream().GiveBack(loan); !given) {
    return tl::unexpected(given.error());
  }
  CountGap(loan.sequence);
  if (marked) {
    tally_->error_frames.Add();
    return nullptr;
  }
  auto frame = std::make_shared<Frame>();
  frame->sequence = loan.sequence;
  frame->arrival = loan.arrival;
  StampExposure(loan, *frame);
  if (!FillPicture(*frame)) {
    tally_->damaged_frames.Add();
    return nullptr;
  }
  last_life_ = loan.arrival;
  unanswered_ns_.store(0);
  unanswered_.store(0);
  answered_ = true;
  restarted_ = false;
  trouble_.reset();
  return frame;
}

void V4l2Camera::StampExposure(const V4l2Loan& loan, Frame& frame) {
  V4l2StampClock::Stamp stamp =
      stamps_.Take(loan.stamp_s, loan.stamp_us, loan.flags, loan.arrival, rule_);
  if (stamp.foreign) tally_->foreign_stamps.Add();
  if (next_exposure_ && stamp.exposure_start >= next_exposure_->set) {
    if (stamp.of_end) {
      stamp.exposure_start = stamp.exposure_start + rule_.exposure - next_exposure_->length;
    }
    rule_.exposure = next_exposure_->length;
    next_exposure_.reset();
  }
  frame.exposure_start = stamp.exposure_start;
  frame.exposure = rule_.exposure;
}

bool V4l2Camera::FillPicture(Frame& frame) const {
  const V4l2PictureFormat& format = session_->format();
  if (FindV4l2PixelFormat(format.fourcc)->layout == V4l2Layout::kMotionJpeg) {
    auto jpeg = ReadMotionJpeg(copy_);
    if (!jpeg || jpeg->width_px != format.width_px || jpeg->height_px != format.height_px) {
      return false;
    }
    frame.format = PixelFormat::kJpeg;
    frame.bytes = std::move(jpeg->bytes);
  } else {
    auto pixels = ConvertV4l2Pixels(format, copy_);
    if (!pixels) return false;
    frame.format = pixels->format;
    frame.bytes = std::move(pixels->bytes);
  }
  frame.width = format.width_px;
  frame.height = format.height_px;
  return true;
}

}  // namespace kawara::drivers
