#include "sim/drive_run.hpp"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <system_error>
#include <thread>

#include "sim/doughnut_pictures.hpp"
#include "sim/folder_pictures.hpp"
#include "sim/truth_log.hpp"

namespace kawara::sim {
namespace {

/// Host's commands and camera pulses are looked at this often when nothing else is due.
constexpr core::Duration kLongestSleep = core::Milliseconds(2);
constexpr int kFifoPriority = 30;

void SleepUntil(core::MonoTime t) {
  const timespec until{.tv_sec = t.ns() / 1'000'000'000, .tv_nsec = t.ns() % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

core::UtcTime UtcNow() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return core::UtcTime::FromNs(std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec);
}

core::Expected<std::unique_ptr<PictureSource>> OpenPictures(const DriveOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_directory(options.panorama, ignored)) {
    auto pictures = FolderPictures::Open(options.panorama);
    if (!pictures) return tl::unexpected(pictures.error());
    return std::make_unique<FolderPictures>(std::move(*pictures));
  }
  auto pictures = DoughnutPictures::Open(options.panorama, options.doughnut, options.jpeg_quality);
  if (!pictures) return tl::unexpected(pictures.error());
  return std::make_unique<DoughnutPictures>(std::move(*pictures));
}

/// The part of the recording that is to be replayed, cut to what was asked for.
struct Span {
  core::GpsTime begin, end;
};
core::Expected<Span> ChooseSpan(const Recording& recording, const DriveOptions& options) {
  const double available_s = core::ToSeconds(recording.end() - recording.begin());
  if (!(options.start_s >= 0.0 && options.start_s < available_s)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "--start " + std::to_string(options.start_s) + ": the recording has " +
                          std::to_string(available_s) + " s");
  }
  const core::GpsTime begin = recording.begin() + core::DurationFromSeconds(options.start_s);
  if (!options.duration_s) return Span{begin, recording.end()};
  if (!(*options.duration_s > 0.0))
    return core::Fail(core::ErrorCode::kInvalidArgument, "--duration must be above 0");
  return Span{begin, std::min(recording.end(), begin + core::DurationFromSeconds(
                                                           std::min(*options.duration_s, 1e7)))};
}

/// Lives as long as the run: scripts wait for this file.
class ReadyFile {
 public:
  ReadyFile(const std::filesystem::path& file, const std::string& text) : file_(file) {
    const std::filesystem::path fresh = file.string() + ".new";
    std::ofstream(fresh) << text;
    std::error_code ignored;
    std::filesystem::rename(fresh, file_, ignored);  // appears whole
  }
  ~ReadyFile() {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }
  ReadyFile(const ReadyFile&) = delete;
  ReadyFile& operator=(const ReadyFile&) = delete;

 private:
  std::filesystem::path file_;
};

/// The fixes that have become true, one line each, as time passes.
class EpochTruth {
 public:
  EpochTruth(const Recording& recording, const SimClock& clock, Span span, TruthLog& log)
      : recording_(recording), clock_(clock), end_(span.end), log_(log) {
    while (next_ < recording.fixes.size() && recording.fixes[next_].time < span.begin) ++next_;
  }
  void Advance(core::MonoTime now) {
    for (; next_ < recording_.fixes.size() && recording_.fixes[next_].time <= end_; ++next_) {
      const RecordedFix& fix = recording_.fixes[next_];
      const core::MonoTime mono = clock_.MonoAt(fix.time);
      if (mono > now) return;
      log_.Epoch(fix.time, mono, fix.antenna, fix.rtk == core::RtkState::kFixed ? 1 : 2);
    }
  }

 private:
  const Recording& recording_;
  const SimClock& clock_;
  core::GpsTime end_;
  TruthLog& log_;
  std::size_t next_ = 0;
};

void AskForRealTime() {
  sched_param priority{};
  priority.sched_priority = kFifoPriority;
  pthread_setschedparam(pthread_self(), SCHED_FIFO,
                        &priority);  // refused without the right to: paced a little worse
}

}  // namespace

std::string DriveSummary::ToText() const {
  std::array<char, 640> text{};
  std::snprintf(
      text.data(), text.size(),
      "kawara-sim: %.1f s%s; gps %llu epochs, %llu sentences, %llu commands (%llu refused), %llu "
      "rtcm, "
      "%llu overrun bytes, %llu dropped messages; ahrs %llu samples, %llu packets, %llu skipped, "
      "%llu saturated, %llu overrun bytes; camera %llu triggers, %llu frames, %llu missed, %llu "
      "lost, "
      "slowest %.1f ms; pacing at most %.1f ms late",
      ran_s, stopped_early ? " (stopped)" : "", static_cast<unsigned long long>(gps.epochs),
      static_cast<unsigned long long>(gps.sentences), static_cast<unsigned long long>(gps.commands),
      static_cast<unsigned long long>(gps.refused),
      static_cast<unsigned long long>(gps.rtcm_messages),
      static_cast<unsigned long long>(gps_line.overrun_bytes),
      static_cast<unsigned long long>(gps_dropped_messages),
      static_cast<unsigned long long>(ahrs.samples), static_cast<unsigned long long>(ahrs.packets),
      static_cast<unsigned long long>(ahrs.skipped),
      static_cast<unsigned long long>(ahrs_saturated),
      static_cast<unsigned long long>(ahrs_line.overrun_bytes),
      static_cast<unsigned long long>(camera.triggers),
      static_cast<unsigned long long>(camera.frames),
      static_cast<unsigned long long>(camera.missed), static_cast<unsigned long long>(camera.lost),
      core::ToSeconds(camera.longest_delivery) * 1e3, core::ToSeconds(latest_wakeup) * 1e3);
  return text.data();
}

core::Expected<DriveSummary> RunDrive(const DriveOptions& options, const std::atomic<bool>& stop) {
  // 1. The recording, and what is derived from it once.
  core::Expected<Recording> loaded = LoadRecording(options.data);
  if (!loaded) return tl::unexpected(loaded.error());
  Recording& recording = *loaded;
  for (RecordedImu& sample : recording.imu)
    sample.time += core::DurationFromSeconds(-options.imu_advance_s);
  recording.site.imu_late_s -= options.imu_advance_s;
  core::Expected<Span> span = ChooseSpan(recording, options);
  if (!span) return tl::unexpected(span.error());
  if (options.now) {
    const std::int64_t ahead_s = (core::ToGps(UtcNow()) - span->begin).count() / 1'000'000'000;
    recording.Shift(core::Seconds(ahead_s));
    span->begin += core::Seconds(ahead_s);
    span->end += core::Seconds(ahead_s);
  }
  const MotionTrack track(recording);
  const std::vector<AhrsState> trace = MakeAhrsTrace(recording, track, options.gps.seed + 1);
  std::unique_ptr<PictureSource> pictures;
  if (!options.panorama.empty()) {
    auto opened = OpenPictures(options);
    if (!opened) return tl::unexpected(opened.error());
    pictures = std::move(*opened);
  }

  // 2. The places where others find us.
  std::error_code error;
  std::filesystem::create_directories(options.run_dir, error);
  if (error)
    return core::Fail(core::ErrorCode::kIo,
                      "run-dir " + options.run_dir.string() + ": " + error.message());
  core::Expected<TruthLog> truth = TruthLog::Create(options.run_dir);
  if (!truth) return tl::unexpected(truth.error());
  core::Expected<Pty> gps_pty = Pty::Create(options.run_dir / "gps");
  if (!gps_pty) return tl::unexpected(gps_pty.error());
  core::Expected<Pty> ahrs_pty = Pty::Create(options.run_dir / "ahrs");
  if (!ahrs_pty) return tl::unexpected(ahrs_pty.error());

  // 3. Time starts a moment from now.
  const core::MonoTime begin = core::MonoNow() + core::DurationFromSeconds(options.lead_s);
  const SimClock clock(span->begin, begin, options.speed * (1.0 + options.machine_skew_ppm * 1e-6));
  const FaultPlan plan(options.faults);
  const auto active = [&](FaultKind kind, core::MonoTime t) {
    return plan.Active(kind, t - begin);
  };

  GpsReceiver gps(recording, clock, span->begin, span->end, options.gps);
  Ahrs400 ahrs(trace, clock, span->begin, span->end, options.ahrs);
  SerialLine gps_line(std::move(*gps_pty), gps, options.gps.seed + 2);
  SerialLine ahrs_line(std::move(*ahrs_pty), ahrs, options.gps.seed + 3);
  EpochTruth epoch_truth(recording, clock, *span, *truth);

  std::unique_ptr<CameraServer> camera;
  std::atomic<bool> camera_stop{false};
  std::thread camera_thread;
  if (pictures) {
    CameraServer::Hooks hooks;
    hooks.faults = [&](core::MonoTime t) {
      return CameraServer::Faults{.hang = active(FaultKind::kCameraHang, t),
                                  .miss = active(FaultKind::kCameraMiss, t),
                                  .late = active(FaultKind::kCameraLate, t),
                                  .disconnected = active(FaultKind::kCameraDisconnect, t)};
    };
    hooks.trigger_pulse = [&](core::MonoTime pulse) { gps.AddEvent(pulse); };
    hooks.exposed = [&](const CameraServer::Exposure& e) {
      truth->Exposure(e.trigger_sequence, e.frame_sequence, e.gps, e.mono, track.PositionAt(e.gps),
                      e.yaw_rad);
    };
    camera = std::make_unique<CameraServer>(options.run_dir / "camera.sock", track, clock,
                                            std::move(pictures), options.camera, std::move(hooks));
    const core::Expected<void> listening = camera->Listen();
    if (!listening) return tl::unexpected(listening.error());
    camera_thread = std::thread([&] { camera->Run(camera_stop); });
  }
  if (options.realtime) AskForRealTime();
  const ReadyFile ready(options.run_dir / "ready",
                        "pid " + std::to_string(getpid()) + "\ngps " + gps_line.pty().device() +
                            "\nahrs " + ahrs_line.pty().device() + "\nbegin_gps_ns " +
                            std::to_string(span->begin.ns()) + "\nbegin_mono_ns " +
                            std::to_string(begin.ns()) + "\nend_gps_ns " +
                            std::to_string(span->end.ns()) + "\n");
  std::printf("kawara-sim: ready in %s (%.1f s of recording)\n", options.run_dir.c_str(),
              core::ToSeconds(span->end - span->begin));
  std::fflush(stdout);

  // 4. Time passes. The last sentences get half a second to leave.
  const core::MonoTime end = clock.MonoAt(span->end) + core::Milliseconds(500);
  DriveSummary summary;
  core::Expected<void> healthy;
  core::MonoTime now = core::MonoNow();
  while (!stop.load() && now < end && healthy) {
    gps.SetFaults({.no_fix = active(FaultKind::kGpsNoFix, now),
                   .bad_checksum = active(FaultKind::kGpsBadSum, now),
                   .power_off = active(FaultKind::kGpsPower, now)});
    healthy = gps_line.Service(now, {.unplugged = active(FaultKind::kGpsUnplug, now),
                                     .silent = active(FaultKind::kGpsSilent, now),
                                     .garbage = active(FaultKind::kGpsGarbage, now)});
    if (healthy) {
      healthy = ahrs_line.Service(now, {.unplugged = active(FaultKind::kAhrsUnplug, now),
                                        .silent = active(FaultKind::kAhrsSilent, now),
                                        .garbage = active(FaultKind::kAhrsGarbage, now)});
    }
    epoch_truth.Advance(now);
    core::MonoTime wake = std::min(now + kLongestSleep, end);
    for (const core::MonoTime due : {gps_line.NextService(), ahrs_line.NextService()}) {
      if (due.IsSet()) wake = std::min(wake, due);
    }
    SleepUntil(wake);
    now = core::MonoNow();
    summary.latest_wakeup = std::max(summary.latest_wakeup, now - wake);
  }

  // 5. Everything down again.
  camera_stop = true;
  if (camera_thread.joinable()) camera_thread.join();
  if (!healthy) return tl::unexpected(healthy.error());
  summary.ran_s = core::ToSeconds(std::min(now, end) - begin);
  summary.stopped_early = now < end;
  summary.gps = gps.counters();
  summary.gps_line = gps_line.counters();
  summary.gps_dropped_messages = gps.transmitter().dropped_messages();
  summary.ahrs = ahrs.counters();
  summary.ahrs_line = ahrs_line.counters();
  summary.ahrs_saturated = ahrs.saturated();
  if (camera) summary.camera = camera->counters();
  return summary;
}

}  // namespace kawara::sim
