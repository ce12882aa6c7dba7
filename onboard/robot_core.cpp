#include "onboard/robot_core.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kawara::onboard {
namespace {

estimation::GpsTimelineConfig TimelineConfig(const GpsConfig& gps) {
  estimation::GpsTimelineConfig config;
  config.envelope.min_latency_s = gps.latency_s;
  config.envelope.min_latency_sigma_s = gps.latency_sd_s;
  config.pps.pulse_sigma_s = gps.pps.stamp_sd_s;
  config.pps.pulse_latency_s = gps.pps.latency_s;
  config.pps.pulse_latency_sigma_s = gps.pps.latency_sd_s;
  return config;
}

drivers::CorrectionForwarderConfig ForwarderConfig(const OnboardConfig& config) {
  drivers::CorrectionForwarderConfig forwarder;
  if (config.gps.profile == "ashtech-legacy") {
    forwarder.receiver_accepts = drivers::CorrectionsAccepted::kRtcm2Only;
  }
  forwarder.watchdog.alarm_age = core::DurationFromSeconds(config.corrections.alarm_age_s);
  return forwarder;
}

/// The receiver tells of only one event between two epochs: exposures that scatter about the epochs
/// themselves would lose some, so they begin a little after.
constexpr double kAfterEpoch_s = 0.002;

ScheduleConfig WithLead(ScheduleConfig schedule, const CameraConfig& camera) {
  schedule.trigger_lead_s = camera.trigger_lead_s;
  if (camera.event_mark != "none") schedule.trigger_lead_s -= kAfterEpoch_s;
  return schedule;
}

}  // namespace

RobotCore::RobotCore(const OnboardConfig& config, core::Counters& counters, CoreSink& out)
    : out_(out),
      timeline_(TimelineConfig(config.gps)),
      navigation_(config, timeline_, events_),
      pulses_(config.gps.pps, timeline_, events_),
      gps_(config.gps, events_, out, *this),
      ahrs_(config.ahrs, events_, out, *this),
      corrections_(ForwarderConfig(config), events_),
      wants_corrections_(config.corrections.source != "none"),
      pictures_(config.camera, WithLead(config.schedule.rule, config.camera), timeline_,
                navigation_, events_, out),
      counters_(counters),
      configured_latency_s_(config.gps.latency_s) {}

void RobotCore::OnInput(const Input& input) {
  out_.OnInput(input);
  switch (input.kind) {
    case InputKind::kGpsBytes:
      gps_.OnBytes(input.mono, input.bytes);
      break;
    case InputKind::kAhrsBytes:
      ahrs_.OnBytes(input.mono, input.bytes);
      break;
    case InputKind::kCorrectionBytes:
      // No bytes: the source had a gap.
      if (input.bytes.empty()) corrections_.Restart();
      corrections_.Feed(input.mono, input.bytes);
      break;
    case InputKind::kPort:
      OnPort(input);
      break;
    case InputKind::kCommand:
      OnCommand(input);
      break;
    case InputKind::kPictureDone:
      pictures_.OnPictureDone();
      break;
    case InputKind::kSystemClock:
      OnSystemClock(input);
      break;
    case InputKind::kNote:
      OnNote(input);
      break;
    case InputKind::kPulse:
      OnPulse(input);
      break;
    case InputKind::kShutter:
      OnShutter(input);
      break;
    case InputKind::kTick:
    case InputKind::kFrame:
      break;
  }
  Advance(input.mono);
}

void RobotCore::OnFrame(const FrameInput& frame) {
  pictures_.OnFrame(std::max(now_, frame.arrival), frame);
  Advance(frame.arrival);
}

core::MonoTime RobotCore::NextDeadline(core::MonoTime now) const {
  return pictures_.NextDeadline(now);
}

/// Time only goes forward here, although chunks are stamped by their first byte.
void RobotCore::Advance(core::MonoTime now) {
  now_ = std::max(now_, now);
  if (wants_corrections_) ForwardCorrections();
  gps_.Tick(now_);
  ahrs_.Tick(now_);
  pictures_.Tick(now_);
  if (now_ >= next_second_) EverySecond(now_);
  SendEvents();
}

void RobotCore::OnGpsFix(const core::GnssFix& fix) {
  // A receiver that tells its own latency (LTN) dates its bursts better than the configured least
  // latency.
  if (std::isfinite(fix.latency_s)) {
    latency_correction_ = core::DurationFromSeconds(fix.latency_s - configured_latency_s_);
  }
  timeline_.AddEpoch(fix.time, fix.arrival - latency_correction_);
  navigation_.AddFix(fix);
  pictures_.OnFix(fix);
}

/// Time tags name the time of the week only; which week is known once there are fixes.
void RobotCore::OnTimeTag(const drivers::AshtechTimeTag& tag, core::MonoTime arrival) {
  if (!timeline_.valid()) return;
  const core::GpsTime time =
      core::ResolveTimeOfWeek(tag.time_of_week, timeline_.ToGps(arrival).time);
  if (tag.is_event) {
    pictures_.OnMark(time);
  } else {
    timeline_.AddPulseLabel(time, arrival);
  }
}

void RobotCore::OnAhrsSample(const core::AhrsSample& sample) {
  out_.OnAhrs(sample, GpsOf(sample.sampled));
  pictures_.OnAhrs(sample);
  const core::Pose pose = navigation_.AddAhrs(sample);
  if (pose.valid) out_.OnPose(pose);
  if (navigation_.TakeChange()) out_.OnNavigation(navigation_.Report(sample.arrival));
}

core::GpsTime RobotCore::GpsOf(core::MonoTime mono) const {
  return timeline_.valid() ? timeline_.ToGps(mono).time : core::GpsTime{};
}

void RobotCore::OnPort(const Input& input) {
  PortNote note;
  if (!Unpack(input.bytes, note)) return;
  static constexpr std::array<const char*, kPorts> kNames{"gps.port", "ahrs.port", "camera.port",
                                                          "pps.port"};
  if (!note.text.empty()) {
    events_.Push(input.mono, note.severity, kNames[static_cast<std::size_t>(note.port)], note.text);
  }
  if (!note.changed) return;
  if (note.port == PortId::kGps) gps_.OnPort(input.mono, note.open);
  if (note.port == PortId::kAhrs) ahrs_.OnPort(input.mono, note.open);
}

void RobotCore::OnCommand(const Input& input) {
  const std::string_view text(reinterpret_cast<const char*>(input.bytes.data()),
                              input.bytes.size());
  const std::string_view verb = text.substr(0, text.find(' '));
  if (verb == "picture") {
    pictures_.RequestPicture();
    events_.Info(input.mono, "command.picture", "a picture was asked for");
  } else {
    core::EventText complaint("unknown command: ");
    events_.WarnLow(input.mono, "command.unknown", complaint.Append(verb));
  }
}

void RobotCore::OnNote(const Input& input) {
  EventNote note;
  if (!Unpack(input.bytes, note)) return;
  out_.OnNote(input.mono, note, GpsOf(input.mono));
}

void RobotCore::OnPulse(const Input& input) {
  std::uint32_t sequence = 0;
  if (Unpack(input.bytes, sequence)) pulses_.OnEdge(input.mono, sequence);
}

void RobotCore::OnShutter(const Input& input) {
  core::Duration length{};
  if (Unpack(input.bytes, length)) pictures_.OnShutter(length);
}

void RobotCore::OnSystemClock(const Input& input) {
  std::int64_t ns = 0;
  if (input.bytes.size() != sizeof(ns)) return;
  std::memcpy(&ns, input.bytes.data(), sizeof(ns));
  const core::UtcTime utc = core::UtcTime::FromNs(ns);
  gps_.SetReference(utc);
  pictures_.OnSystemClock(input.mono, utc);
}

void RobotCore::ForwardCorrections() {
  gps_.corrections_allowed() ? corrections_.Release() : corrections_.Hold();
  while (!corrections_.Output().empty()) {
    const auto bytes = corrections_.Output();
    out_.Write(PortId::kGps, bytes);
    corrections_.Consume(bytes.size());
  }
}

void RobotCore::EverySecond(core::MonoTime now) {
  next_second_ = now + core::Seconds(1);
  if (wants_corrections_) corrections_.Tick(now);
  pulses_.Tick(now);
  if (timeline_.valid()) out_.OnClock(timeline_.Status(now));
  const estimation::NavigationReport navigation = navigation_.Report(now);
  if (navigation_.has_filter()) out_.OnNavigation(navigation);
  counters_.Set(gps_.stream_stats(), gps_.epoch_stats());
  counters_.Set(ahrs_.stats());
  counters_.Set(corrections_.stats());
  counters_.Set(pulses_.stats());
  counters_.Set(pictures_);
  counters_.Set(navigation, navigation_.navigator().stats());
  events_.Flush(now);
}

void RobotCore::SendEvents() {
  core::Event event;
  while (events_.TryPop(event)) {
    out_.OnEvent(event, GpsOf(event.stamp));
  }
}

}  // namespace kawara::onboard
