#include "onboard/replay_robot.hpp"

#include <kawara/config_t.hpp>
#include <kawara/event_t.hpp>
#include <kawara/frame_t.hpp>
#include <kawara/raw_bytes_t.hpp>
#include <memory>
#include <utility>

#include "comms/codec.hpp"
#include "comms/recorder.hpp"
#include "core/config/config.hpp"
#include "onboard/frame_table.hpp"
#include "onboard/message_sink.hpp"
#include "onboard/phase1_assembler.hpp"
#include "onboard/robot_core.hpp"

namespace kawara::onboard {
namespace {

/// Messages as live, but the inputs are in the log already, and pictures are made on the spot.
class ReplaySink final : public MessageSink {
 public:
  ReplaySink(const RobotConfig& robot, FrameTable& frames, Emit emit,
             std::optional<Phase1Assembler>& assembler, ReplayStats& stats)
      : MessageSink(robot, frames, std::move(emit)),
        frames_(frames),
        assembler_(assembler),
        stats_(stats) {}

  void OnInput(const Input& /*input*/) override {}
  void OnFrame(const FrameInput& frame, bool selected) override {
    if (!selected) frames_.Release(frame.slot);
  }
  void OnFix(const core::GnssFix& fix) override {
    ++stats_.fixes;
    MessageSink::OnFix(fix);
  }
  void OnPose(const core::Pose& pose) override {
    ++stats_.poses;
    MessageSink::OnPose(pose);
  }
  void OnEvent(const core::Event& event, core::GpsTime time) override {
    ++stats_.events;
    MessageSink::OnEvent(event, time);
  }
  void OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) override {
    ++stats_.events;
    MessageSink::OnNote(mono, note, time);
  }
  void OnPicture(const PictureOrder& order) override {
    if (auto frame = frames_.Get(order.slot); assembler_ && frame && !frame->bytes.empty()) {
      assembler_->OnFrame(order.epoch, std::move(frame));
    }
    frames_.Release(order.slot);
  }
  void OnExposurePose(const ExposurePose& pose) override {
    MessageSink::OnExposurePose(pose);
    if (!assembler_) return;
    assembler_->OnPose(pose);
    while (assembler_->Work()) {
    }
  }

 private:
  FrameTable& frames_;
  std::optional<Phase1Assembler>& assembler_;
  ReplayStats& stats_;
};

void FeedFrame(std::span<const std::uint8_t> data, FrameTable& frames, RobotCore& core,
               ReplayStats& stats) {
  const auto message = comms::Decode<frame_t>(data);
  if (!message) return;
  ++stats.frames;
  auto frame = std::make_shared<drivers::Frame>();
  frame->sequence = static_cast<std::uint32_t>(message->sequence);
  frame->trigger_sequence = static_cast<std::uint32_t>(message->trigger_sequence);
  frame->exposure_start = core::MonoTime::FromNs(message->exposure_start_mono_ns);
  frame->arrival = core::MonoTime::FromNs(message->arrival_mono_ns);
  frame->format = static_cast<drivers::PixelFormat>(message->format);
  frame->width = static_cast<std::uint32_t>(message->width);
  frame->height = static_cast<std::uint32_t>(message->height);
  frame->bytes = message->data;
  if (frame->bytes.empty()) ++stats.frames_without_pixels;

  FrameInput input;
  input.sequence = message->input_sequence;
  input.frame_sequence = frame->sequence;
  input.trigger_sequence = frame->trigger_sequence;
  input.exposure_start = frame->exposure_start;
  input.arrival = frame->arrival;
  const auto slot = frames.Put(std::move(frame));
  input.slot = slot.value_or(FrameTable::kSlots);
  core.OnFrame(input);
}

/// The core never knew of these, so it cannot say them again.
bool IsRecorderEvent(const comms::LogEvent& logged) {
  if (logged.channel != "EVENT") return false;
  const auto event = comms::Decode<event_t>(logged.data);
  return event && comms::IsRecorderEvent(*event);
}

}  // namespace

core::Expected<OnboardConfig> ReplayRobot::RecordedConfig(comms::EventLogReader& reader) {
  while (const auto event = reader.Next()) {
    if (event->channel != "CONFIG") continue;
    const auto message = comms::Decode<config_t>(event->data);
    if (!message || message->program != "kawara-onboard") continue;
    return core::config::Parse<OnboardConfig>(message->yaml, "CONFIG of the log");
  }
  return core::Fail(core::ErrorCode::kFormat,
                    "this log holds no CONFIG of kawara-onboard: give the robot's configuration "
                    "with --config");
}

core::Expected<ReplayStats> ReplayRobot::Play(comms::EventLogReader& reader,
                                              const OnboardConfig& config, const Emit& emit) {
  ReplayStats stats;
  std::int64_t time_utc_us = 0;
  const auto send = [&](std::string_view channel, std::span<const std::uint8_t> bytes) {
    emit(channel, bytes, time_utc_us);
  };
  std::optional<Phase1Assembler> assembler;
  if (config.camera.source != "none") {
    auto made = Phase1Assembler::Create(
        config.picture,
        {config.robot.name, config.robot.mission, config.camera.make, config.camera.model},
        [&](std::span<const std::uint8_t> bytes) { send("PHASE1", bytes); },
        [](const core::Error&) {});  // the complaint was made when the frame came
    if (!made) return tl::unexpected(made.error());
    assembler.emplace(std::move(*made));
  }
  FrameTable frames;
  ReplaySink sink(
      config.robot, frames,
      [&](std::string_view channel, std::span<const std::uint8_t> bytes, MessageSink::Reach) {
        send(channel, bytes);
      },
      assembler, stats);
  core::Counters counters;
  RobotCore core(config, counters, sink);

  while (const auto event = reader.Next()) {
    time_utc_us = event->time_utc_us;
    if (IsRecorderEvent(*event)) {
      ++stats.events;
      send("EVENT", event->data);
      continue;
    }
    InputKind kind{};
    if (!KindOf(event->channel, kind)) continue;
    ++stats.inputs;
    if (kind == InputKind::kFrame) {
      FeedFrame(event->data, frames, core, stats);
      continue;
    }
    const auto input = comms::Decode<raw_bytes_t>(event->data);
    if (!input) continue;
    core.OnInput({kind, input->sequence, core::MonoTime::FromNs(input->mono_ns), input->data});
  }
  if (assembler) {
    stats.previews = assembler->stats().previews;
    stats.pictures = assembler->stats().pictures;
  }
  return stats;
}

}  // namespace kawara::onboard
