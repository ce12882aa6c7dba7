#include "onboard/message_sink.hpp"

#include <kawara/event_t.hpp>
#include <kawara/frame_t.hpp>
#include <kawara/raw_bytes_t.hpp>
#include <kawara/robot_pose_t.hpp>

#include "comms/codec.hpp"
#include "comms/convert.hpp"
#include "core/check.hpp"

namespace kawara::onboard {
namespace {

/// One line of text. Events quote what instruments and the bus say, which may be any bytes; a
/// message cannot carry a NUL, and a terminal should not obey an escape.
std::string Line(std::string_view text) {
  std::string line(text);
  for (char& c : line) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) c = '?';
  }
  return line;
}

}  // namespace

template <class T>
void MessageSink::Send(std::string_view channel, const T& message, Reach reach) {
  const auto bytes = comms::Encode(message);
  CORE_CHECK(bytes.has_value());  // arrays are as long as their counts say, texts without NUL
  emit_(channel, *bytes, reach);
}

void MessageSink::OnInput(const Input& input) {
  raw_bytes_t message;
  message.mono_ns = input.mono.ns();
  message.sequence = input.sequence;
  message.n = static_cast<std::int32_t>(input.bytes.size());
  message.data.assign(input.bytes.begin(), input.bytes.end());
  Send(ChannelOf(input.kind), message, Reach::kLogOnly);
}

void MessageSink::OnFrame(const FrameInput& frame, bool /*selected*/) {
  frame_t message;
  message.input_sequence = frame.sequence;
  message.sequence = frame.frame_sequence;
  message.trigger_sequence = frame.trigger_sequence;
  message.exposure_start_mono_ns = frame.exposure_start.ns();
  message.arrival_mono_ns = frame.arrival.ns();
  if (const auto pixels = frames_.Get(frame.slot)) {
    message.format = static_cast<std::int32_t>(pixels->format);
    message.width = static_cast<std::int32_t>(pixels->width);
    message.height = static_cast<std::int32_t>(pixels->height);
    message.n = static_cast<std::int32_t>(pixels->bytes.size());
    message.data = pixels->bytes;
  } else {
    message.format = message.width = message.height = message.n = 0;
  }
  Send(ChannelOf(InputKind::kFrame), message, Reach::kLogOnly);
}

void MessageSink::OnFix(const core::GnssFix& fix) {
  Send("GNSS", comms::ToMessage(fix), Reach::kBusAndLog);
}

void MessageSink::OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) {
  Send("AHRS", comms::ToMessage(sample, sampled), Reach::kBusAndLog);
}

void MessageSink::SendPose(std::string_view channel, const core::Pose& pose) {
  robot_pose_t message;
  message.robot = robot_.name;
  message.mission = robot_.mission;
  message.pose = comms::ToMessage(pose);
  Send(channel, message, Reach::kBusAndLog);
}

void MessageSink::OnPose(const core::Pose& pose) { SendPose("POSE", pose); }

void MessageSink::OnExposurePose(const ExposurePose& pose) { SendPose("POSE.EPOCH", pose.body); }

void MessageSink::OnNavigation(const estimation::NavigationReport& report) {
  auto message = comms::ToMessage(report);
  message.robot = robot_.name;
  message.mission = robot_.mission;
  Send("NAV", message, Reach::kBusAndLog);
}

void MessageSink::OnClock(const estimation::ClockStatus& clock) {
  Send("CLOCK", comms::ToMessage(clock), Reach::kBusAndLog);
}

void MessageSink::OnEvent(const core::Event& event, core::GpsTime time) {
  SendEvent(event.stamp, {event.severity, event.name, event.text.view()}, event.suppressed, time);
}

void MessageSink::OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) {
  SendEvent(mono, note, 0, time);
}

void MessageSink::SendEvent(core::MonoTime mono, const EventNote& note, std::int64_t suppressed,
                            core::GpsTime time) {
  event_t message;
  message.robot = robot_.name;
  message.mission = robot_.mission;
  message.mono_ns = mono.ns();
  message.gps_ns = time.ns();
  message.severity = static_cast<std::int8_t>(note.severity);
  message.name = Line(note.name);
  message.text = Line(note.text);
  message.suppressed = suppressed;
  Send("EVENT", message, Reach::kBusAndLog);
}

}  // namespace kawara::onboard
