#include "tools/navigate/log_recording.hpp"

#include <filesystem>
#include <kawara/raw_bytes_t.hpp>
#include <utility>

#include "comms/codec.hpp"
#include "comms/event_log_reader.hpp"
#include "core/config/config.hpp"
#include "core/counters.hpp"
#include "estimation/navigation_config.hpp"
#include "onboard/config.hpp"
#include "onboard/navigation_chain.hpp"
#include "onboard/replay_robot.hpp"
#include "onboard/robot_core.hpp"
#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

/// Takes the samples out of the core's talk. Times keep their distance, but count from the begin of
/// the first one's week.
class SampleCollector final : public onboard::CoreSink {
 public:
  SampleCollector(double declination_rad, LogRecording& recording)
      : declination_rad_(declination_rad), recording_(recording) {}

  void OnFix(const core::GnssFix& fix) override {
    if (!fix.time.IsSet()) return;
    GnssRow row;
    row.fix = fix;
    row.fix.time = InFileWeek(fix.time);
    // Just behind the newest sample: it is the next one that finds this fix there.
    row.received =
        recording_.imu.empty() ? row.fix.time : recording_.imu.back().time + core::Nanoseconds(1);
    if (fix.has_heading) {
      estimation::AttitudeSample heading;
      heading.time = row.fix.time;
      heading.has_heading = true;
      heading.attitude.yaw_rad = fix.heading_rad;
      heading.heading_sd_rad = estimation::NavigationConfig().two_antenna_sd_rad;
      row.heading = heading;
      row.fix.has_heading = false;  // not twice
    }
    recording_.gnss.push_back(std::move(row));
  }

  void OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) override {
    if (!sampled.IsSet()) return;  // before the first time line
    const core::GpsTime time = InFileWeek(sampled);
    if (sample.has_attitude) {
      estimation::AttitudeSample attitude;
      attitude.time = time;
      attitude.has_level = attitude.has_heading = true;
      attitude.attitude = sample.attitude;
      attitude.attitude.yaw_rad = core::WrapPi(attitude.attitude.yaw_rad + declination_rad_);
      recording_.attitudes.push_back({time, attitude});
    }
    recording_.imu.push_back({time, sample.rate_radps, sample.specific_force_mps2});
  }

  void OnInput(const onboard::Input& /*input*/) override {}
  void OnFrame(const onboard::FrameInput& /*frame*/, bool /*selected*/) override {}
  void OnPose(const core::Pose& /*pose*/) override {}
  void OnNavigation(const estimation::NavigationReport& /*report*/) override {}
  void OnClock(const estimation::ClockStatus& /*clock*/) override {}
  void OnEvent(const core::Event& /*event*/, core::GpsTime /*time*/) override {}
  void OnNote(core::MonoTime /*mono*/, const onboard::EventNote& /*note*/,
              core::GpsTime /*time*/) override {}
  void OnPicture(const onboard::PictureOrder& /*order*/) override {}
  void OnExposurePose(const onboard::ExposurePose& /*pose*/) override {}
  void Trigger(std::uint32_t /*sequence*/) override {}
  void Write(onboard::PortId /*port*/, std::span<const std::uint8_t> /*bytes*/) override {}
  void SetBaud(onboard::PortId /*port*/, int /*baud_bps*/) override {}

 private:
  core::GpsTime InFileWeek(core::GpsTime t) {
    if (!shift_) {
      shift_ = *ParseSeconds("0") - core::FromWeek({.week = core::ToWeek(t).week});
    }
    return t + *shift_;
  }

  double declination_rad_;
  LogRecording& recording_;
  std::optional<core::Duration> shift_;
};

core::Expected<onboard::OnboardConfig> ConfigOf(const std::vector<std::filesystem::path>& paths,
                                                const std::string& config_path) {
  if (!config_path.empty()) return core::config::Load<onboard::OnboardConfig>(config_path);
  auto reader = comms::EventLogReader::Open(paths);
  if (!reader) return tl::unexpected(reader.error());
  return onboard::ReplayRobot::RecordedConfig(*reader);
}

}  // namespace

core::Expected<LogRecording> ReadLog(const std::vector<std::string>& paths,
                                     const std::string& config_path) {
  const std::vector<std::filesystem::path> files(paths.begin(), paths.end());
  const auto config = ConfigOf(files, config_path);
  if (!config) return tl::unexpected(config.error());
  auto reader = comms::EventLogReader::Open(files);
  if (!reader) return tl::unexpected(reader.error());

  LogRecording recording;
  recording.navigation = onboard::FilterConfig(*config);
  SampleCollector collector(config->ahrs.magnetic_declination_deg * core::kRadFromDeg, recording);
  core::Counters counters;
  onboard::RobotCore robot(*config, counters, collector);
  while (const auto event = reader->Next()) {
    onboard::InputKind kind{};
    // Pictures say nothing about where the robot is.
    if (!onboard::KindOf(event->channel, kind) || kind == onboard::InputKind::kFrame) continue;
    const auto input = comms::Decode<raw_bytes_t>(event->data);
    if (!input) continue;
    robot.OnInput({kind, input->sequence, core::MonoTime::FromNs(input->mono_ns), input->data});
  }
  if (reader->stats().damage_count > 0) {
    recording.remarks.push_back(
        paths.front() + ": damaged in " + std::to_string(reader->stats().damage_count) +
        " place(s), what was hit is missing (kawara-log check tells where)");
  }
  if (recording.imu.empty() || recording.gnss.empty()) {
    return core::Fail(core::ErrorCode::kFormat,
                      paths.front() + ": no " +
                          (recording.gnss.empty() ? "GNSS epochs" : "dated inertial samples") +
                          " in this log: nothing to navigate by");
  }
  return recording;
}

}  // namespace kawara::navigate
