#include "onboard/live_robot.hpp"

#include <cstdio>
#include <kawara/config_t.hpp>
#include <vector>

#include "comms/codec.hpp"
#include "comms/lcm_bus.hpp"
#include "comms/lcm_schema.hpp"
#include "comms/recorder.hpp"
#include "core/check.hpp"
#include "core/config/config.hpp"
#include "core/iso8601.hpp"
#include "onboard/camera_source.hpp"
#include "onboard/pps_reader.hpp"
#include "onboard/pps_source.hpp"
#include "onboard/pump.hpp"
#include "onboard/realtime.hpp"
#include "onboard/rt_loop.hpp"

namespace kawara::onboard {
namespace {

/// Minutes of everything the core says, should the pump be held up.
constexpr std::size_t kOutputRingBytes = 8U << 20;

comms::RecorderConfig RecorderConfigOf(const OnboardConfig& config) {
  comms::RecorderConfig recorder;
  recorder.folder = config.record.folder;
  recorder.robot = config.robot.name;
  recorder.mission = config.robot.mission;
  recorder.segment_bytes = static_cast<std::uint64_t>(config.record.segment_mb * 1e6);
  recorder.segment_duration = core::DurationFromSeconds(config.record.segment_s);
  recorder.navigation_sync = core::DurationFromSeconds(config.record.navigation_sync_s);
  recorder.picture_sync = core::DurationFromSeconds(config.record.picture_sync_s);
  recorder.disk_reserve_bytes = static_cast<std::uint64_t>(config.record.disk_reserve_mb * 1e6);
  return recorder;
}

void PostNote(InputInbox& inbox, core::Severity severity, std::string_view name,
              std::string_view text) {
  const NoteBytes bytes = Pack(EventNote{severity, name, text});
  inbox.Post(InputKind::kNote, core::MonoNow(), BytesOf(bytes.view()));
}

}  // namespace

std::vector<std::uint8_t> ConfigMessage(const OnboardConfig& config) {
  config_t message;
  message.program = "kawara-onboard";
  message.version = KAWARA_VERSION;
  message.yaml = PublicYaml(config);
  message.lcmtypes = comms::LcmTypesText();
  auto bytes = comms::Encode(message);
  CORE_CHECK(bytes.has_value());
  return std::move(*bytes);
}

std::string MissionAt(core::UtcTime begin) {
  const core::CivilTime t = core::ToCivil(begin);
  char text[32];
  std::snprintf(text, sizeof(text), "%04d%02d%02dT%02d%02d%02dZ", t.year, t.month, t.day, t.hour,
                t.minute, t.second);
  return text;
}

std::string PublicYaml(OnboardConfig config) {
  if (!config.corrections.password.empty()) config.corrections.password = "(not shown)";
  return core::config::Dump(config);
}

/// Declared in the order of construction; destroyed in reverse.
struct LiveRobot::Parts {
  OnboardConfig config;
  core::Counters counters;
  InputInbox inbox;
  OutputRing output{kOutputRingBytes};
  FrameTable frames;
  std::unique_ptr<comms::LcmBus> bus;
  std::unique_ptr<Outlet> outlet;
  std::unique_ptr<comms::Recorder> recorder;
  std::unique_ptr<PictureWorker> pictures;
  std::unique_ptr<CorrectionSource> corrections;
  std::unique_ptr<SystemClockReference> system_clock;
  std::unique_ptr<Pump> pump;
  CameraSource camera;
  std::unique_ptr<RtLoop> loop;
  std::unique_ptr<CameraReader> camera_reader;
  std::unique_ptr<drivers::PpsSource> pps;
  std::unique_ptr<PpsReader> pps_reader;
  std::vector<HeartWatch> hearts;
  bool stopped = false;
};

core::Expected<std::unique_ptr<LiveRobot>> LiveRobot::Start(const OnboardConfig& config) {
  auto parts = std::make_unique<Parts>();
  Parts& p = *parts;
  p.config = config;
  if (p.config.robot.mission.empty()) {
    p.config.robot.mission = MissionAt(core::UtcTime::FromNs(WallClockUs() * 1000));
  }

  auto bus = comms::LcmBus::Open({.url = config.lcm_url});
  if (!bus) return tl::unexpected(bus.error());
  p.bus = std::move(*bus);
  for (const std::string& warning : p.bus->warnings()) {
    PostNote(p.inbox, core::Severity::kWarnLow, "bus.degraded", warning);
  }
  p.outlet = std::make_unique<Outlet>(*p.bus, p.counters);
  if (config.record.enabled) {
    const std::vector<std::uint8_t> config_message = ConfigMessage(p.config);
    auto recorder = comms::Recorder::Start(
        RecorderConfigOf(p.config), config_message,
        [&outlet = *p.outlet](const comms::RecorderEvent& event) { outlet.Publish(event); });
    if (!recorder) return tl::unexpected(recorder.error());
    p.recorder = std::move(*recorder);
    p.outlet->RecordTo(*p.recorder);
  }

  if (config.camera.source != "none") {
    Phase1Assembler::Identity identity{p.config.robot.name, p.config.robot.mission,
                                       config.camera.make, config.camera.model};
    auto assembler = Phase1Assembler::Create(
        config.picture, std::move(identity),
        [&outlet = *p.outlet](std::span<const std::uint8_t> bytes) {
          outlet.Send("PHASE1", bytes, Outlet::Reach::kBusAndLog);
        },
        [&inbox = p.inbox](const core::Error& error) {
          PostNote(inbox, core::Severity::kWarnHigh, "phase1.damaged_frame", error.message);
        });
    if (!assembler) return tl::unexpected(assembler.error());
    p.pictures = std::make_unique<PictureWorker>(std::move(*assembler), p.frames, p.inbox);
    p.camera = MakeCamera(config, p.counters);
  }
  p.corrections = std::make_unique<CorrectionSource>(config.corrections, p.inbox);
  if (config.system_clock.ntp_shm_unit >= 0) {
    p.system_clock = std::make_unique<SystemClockReference>(
        config.system_clock.ntp_shm_unit, p.counters, [&inbox = p.inbox](const EventNote& note) {
          PostNote(inbox, note.severity, note.name, note.text);
        });
  }
  p.pump = std::make_unique<Pump>(
      Pump::Parts{p.output, p.inbox, p.frames, *p.outlet, *p.bus, p.counters, p.pictures.get(),
                  *p.corrections, p.system_clock.get(), config.camera.RunsFreely()},
      p.config.robot, config.corrections.source == "lcm");
  p.loop = std::make_unique<RtLoop>(p.config, p.counters, p.inbox, p.output, p.camera.camera.get());
  if (config.realtime.lock_memory) {
    for (const std::string& complaint : LockMemory()) {
      PostNote(p.inbox, core::Severity::kWarnLow, "realtime.degraded", complaint);
    }
  }
  p.pump->Start();
  p.loop->Start();
  if (p.camera.camera) {
    p.camera_reader = std::make_unique<CameraReader>(*p.camera.camera, p.frames, p.inbox,
                                                     p.counters, p.camera.watch);
  }
  if (!config.gps.pps.device.empty()) {
    p.pps = MakePps(config.gps.pps);
    p.pps_reader = std::make_unique<PpsReader>(*p.pps, p.inbox, p.counters);
  }
  p.hearts = {HeartWatch(p.loop->heart()), HeartWatch(p.pump->heart())};
  return std::unique_ptr<LiveRobot>(new LiveRobot(std::move(parts)));
}

LiveRobot::LiveRobot(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

LiveRobot::~LiveRobot() { Stop(); }

void LiveRobot::Stop() {
  Parts& p = *parts_;
  if (p.stopped) return;
  p.stopped = true;
  if (p.pps_reader) p.pps_reader->Stop();
  if (p.camera_reader) p.camera_reader->Stop();
  p.corrections->Stop();
  p.loop->Stop();
  p.pump->Stop();
  if (p.pictures) p.pictures->Stop();
  if (p.recorder) p.recorder->Stop();
}

bool LiveRobot::IsAlive() {
  bool alive = true;
  for (HeartWatch& heart : parts_->hearts) alive = heart.HasBeaten() && alive;
  return alive;
}

std::string LiveRobot::Summary() const {
  const Parts& p = *parts_;
  std::int64_t fixes = 0, packets = 0, pictures = 0, missed = 0, lost = 0;
  for (const core::Counters::Value& counter : p.counters.Snapshot()) {
    if (counter.name == "gps.fixes") fixes = counter.value;
    if (counter.name == "ahrs.packets") packets = counter.value;
    if (counter.name == "phase1.ordered") pictures = counter.value;
    if (counter.name == "camera.missed") missed = counter.value;
    if (counter.name == "rt.output_refused" || counter.name == "recorder.refused") {
      lost += counter.value;
    }
  }
  char text[400];
  std::snprintf(text, sizeof(text),
                "kawara-onboard: mission %s: %lld fixes, %lld AHRS packets, %lld pictures "
                "(%lld triggers without frame), %lld records lost; log: %s",
                p.config.robot.mission.c_str(), static_cast<long long>(fixes),
                static_cast<long long>(packets), static_cast<long long>(pictures),
                static_cast<long long>(missed), static_cast<long long>(lost),
                p.recorder ? p.recorder->mission_folder().c_str() : "none");
  return text;
}

}  // namespace kawara::onboard
