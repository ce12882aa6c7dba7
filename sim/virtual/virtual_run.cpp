#include "sim/virtual/virtual_run.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "comms/event_log_writer.hpp"
#include "onboard/live_robot.hpp"
#include "sim/virtual/virtual_port.hpp"
#include "sim/virtual/virtual_robot.hpp"

namespace kawara::sim {
namespace {

/// Where the monotonic clock of the robot's computer stands when it is switched on.
constexpr core::MonoTime kPowerOn = core::MonoTime::FromNs(1'000'000'000'000);
/// Faults begin and end at whole multiples of this.
constexpr core::Duration kLook = core::Milliseconds(10);
/// The last sentences need this to leave.
constexpr core::Duration kAfterwards = core::Milliseconds(500);

/// The recorder's part: everything in its order, dated by the UTC of the simulated instant.
class Log {
 public:
  static core::Expected<Log> Create(const std::filesystem::path& file, const SimClock& clock) {
    comms::LogWriterOptions options;
    options.fdatasync = false;  // it can be made again
    auto writer = comms::EventLogWriter::Create(file, options);
    if (!writer) return tl::unexpected(writer.error());
    return Log(std::move(*writer), clock);
  }
  void Append(std::string_view channel, std::span<const std::uint8_t> bytes, core::MonoTime now) {
    if (!written_) return;
    written_ = writer_.Append(core::ToUtc(clock_->GpsAt(now)).ns() / 1000, channel, bytes, now);
  }
  const core::Expected<void>& written() const { return written_; }
  core::Expected<void> Close() { return written_ ? writer_.Close() : written_; }

 private:
  Log(comms::EventLogWriter writer, const SimClock& clock)
      : writer_(std::move(writer)), clock_(&clock) {}
  comms::EventLogWriter writer_;
  const SimClock* clock_;
  core::Expected<void> written_;
};

/// Instruments, camera and robot at each other's ends of cables.
class Coupling {
 public:
  Coupling(const InstrumentOptions& options, const MeasuredMotion& motion, const SimClock& clock,
           core::MonoTime begin, TruthLog& truth)
      : gps_(new VirtualPort("gps")),
        ahrs_(new VirtualPort("ahrs")),
        clock_(clock),
        camera_options_(options.camera),
        instruments_(options, motion, clock, begin, Ports(motion), truth) {}
  Coupling(const Coupling&) = delete;
  Coupling& operator=(const Coupling&) = delete;

  core::Expected<void> Start(onboard::OnboardConfig config, std::uint64_t seed, Log& log,
                             std::unique_ptr<PictureSource> pictures, core::MonoTime now) {
    const bool seeing = pictures && config.camera.source != "none";
    VirtualRobot::World world{*gps_, *ahrs_, {}, {}, {}};
    world.utc_at = [this](core::MonoTime t) { return core::ToUtc(clock_.GpsAt(t)); };
    world.emit = [&log](std::string_view channel, std::span<const std::uint8_t> bytes,
                        core::MonoTime t) { log.Append(channel, bytes, t); };
    if (seeing) {
      camera_.emplace(clock_, std::move(pictures), camera_options_, CameraHooks());
      world.trigger = [this](std::uint32_t sequence, core::MonoTime t) { Trigger(sequence, t); };
    }
    if (config.robot.mission.empty()) config.robot.mission = onboard::MissionAt(world.utc_at(now));
    log.Append("CONFIG", onboard::ConfigMessage(config), now);
    auto robot = VirtualRobot::Create(config, std::move(world), seed, now);
    if (!robot) return tl::unexpected(robot.error());
    robot_ = std::move(*robot);
    next_look_ = now;
    return {};
  }

  /// Does what is due by `now`.
  core::Expected<void> Step(core::MonoTime now) {
    now_ = now;
    gps_->SetTime(now);
    ahrs_->SetTime(now);
    if (now >= NextInstruments()) {
      if (auto healthy = instruments_.Service(now); !healthy) return healthy;
      next_look_ = now + kLook;
      TellOfCamera();
    }
    robot_->Step(now);
    return {};
  }
  /// When Step() has something to do next.
  core::MonoTime Next() const { return std::min(NextInstruments(), robot_->NextStep()); }

  InstrumentSet& instruments() { return instruments_; }
  VirtualRobot& robot() { return *robot_; }
  CameraServer::Counters camera_counters() const {
    CameraServer::Counters counters;
    if (!camera_) return counters;
    counters.triggers = camera_->counters().triggers;
    counters.missed = camera_->counters().missed;
    counters.lost = camera_->counters().spoiled + not_delivered_;
    counters.frames = delivered_;
    return counters;
  }

 private:
  /// The ports belong to the instruments' lines; the raw pointers are the robot's ends of them.
  InstrumentSet::Ports Ports(const MeasuredMotion& motion) {
    InstrumentSet::Ports ports;
    ports.gps.reset(gps_);
    ports.ahrs.reset(ahrs_);
    for (const ScannerSetup& setup : motion.scanners) {
      ports.scanners.push_back(std::make_unique<VirtualPort>(setup.port));
    }
    ports.pulses = [this](const drivers::PpsEdge& edge) { robot_->OnPulse(now_, edge); };
    return ports;
  }
  TriggeredCamera::Hooks CameraHooks() {
    return {[this](core::MonoTime pulse) { instruments_.OnCameraSignal(pulse); },
            [this](const TriggeredCamera::Exposure& e) { instruments_.OnExposure(e); }};
  }

  core::MonoTime NextInstruments() const {
    core::MonoTime next = next_look_;
    for (const core::MonoTime due :
         {instruments_.NextService(), gps_->NextByteOut(), ahrs_->NextByteOut()}) {
      if (due.IsSet()) next = std::min(next, due);
    }
    return next;
  }

  /// The camera's wire: what CameraServer's socket does.
  void Trigger(std::uint32_t sequence, core::MonoTime now) {
    const TriggeredCamera::Faults faults = instruments_.camera_faults();
    if (faults.disconnected || faults.hang) return;
    for (const TriggeredCamera::Frame& frame : camera_->OnTrigger(sequence, now, now, faults)) {
      if (robot_->OnFrame(now, frame)) {
        ++delivered_;
      } else {
        ++not_delivered_;
      }
    }
  }
  void TellOfCamera() {
    if (!camera_) return;
    const bool there = !instruments_.camera_faults().disconnected;
    if (there == camera_there_) return;
    camera_there_ = there;
    if (!there) camera_->Forget();
    robot_->OnCameraPort(now_, there);
  }

  VirtualPort* gps_;
  VirtualPort* ahrs_;
  const SimClock& clock_;
  CameraOptions camera_options_;
  InstrumentSet instruments_;
  std::optional<TriggeredCamera> camera_;
  std::unique_ptr<VirtualRobot> robot_;
  core::MonoTime now_, next_look_;
  bool camera_there_ = true;
  std::uint64_t delivered_ = 0, not_delivered_ = 0;
};

}  // namespace

core::Expected<InstrumentSummary> RunVirtual(const InstrumentOptions& options,
                                             const VirtualTime& virtual_time,
                                             const MeasuredMotion& motion,
                                             std::unique_ptr<PictureSource> pictures,
                                             const std::atomic<bool>& stop) {
  if (auto made = PrepareRunDir(options.run_dir); !made) return tl::unexpected(made.error());
  auto truth = TruthLog::Create(options.run_dir, motion.world, motion.begin);
  if (!truth) return tl::unexpected(truth.error());
  const core::MonoTime begin = kPowerOn + core::DurationFromSeconds(options.lead_s);
  const SimClock clock(motion.begin, begin, 1.0 + options.machine_skew_ppm * 1e-6);
  auto log = Log::Create(virtual_time.log, clock);
  if (!log) return tl::unexpected(log.error());

  const core::MonoTime wall_begin = core::MonoNow();
  Coupling all(options, motion, clock, begin, *truth);
  auto healthy =
      all.Start(virtual_time.onboard, options.gps.seed + 10, *log, std::move(pictures), kPowerOn);
  const core::MonoTime end = clock.MonoAt(motion.end) + kAfterwards;
  core::MonoTime now = kPowerOn;
  while (healthy && log->written() && now < end && !stop.load()) {
    healthy = all.Step(now);
    now = std::max(all.Next(), now + core::Nanoseconds(1));
  }
  now = std::min(now, end);
  if (healthy) all.robot().Finish(now);
  if (healthy) healthy = log->Close();
  if (healthy) healthy = all.instruments().FinishTruth(now);
  if (!healthy) return tl::unexpected(healthy.error());

  const VirtualRobot::Stats& robot = all.robot().stats();
  std::printf(
      "kawara-sim: virtual time: %.1f s in %.1f s; robot: %lld inputs, %lld fixes, %lld poses, "
      "%lld packets of pictures; log %s\n",
      core::ToSeconds(now - kPowerOn), core::ToSeconds(core::MonoNow() - wall_begin),
      static_cast<long long>(robot.inputs), static_cast<long long>(robot.fixes),
      static_cast<long long>(robot.poses), static_cast<long long>(robot.pictures),
      virtual_time.log.c_str());
  InstrumentSummary summary;
  summary.ran_s = core::ToSeconds(now - begin);
  summary.stopped_early = now < end;
  summary.instruments = all.instruments().counters();
  summary.camera = all.camera_counters();
  return summary;
}

}  // namespace kawara::sim
