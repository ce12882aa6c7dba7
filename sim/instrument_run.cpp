#include "sim/instrument_run.hpp"

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

#include "sim/janitor.hpp"
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
  EpochTruth(const MeasuredMotion& motion, const SimClock& clock, TruthLog& log)
      : motion_(motion), clock_(clock), log_(log) {
    const auto& fixes = motion.recording.fixes;
    while (next_ < fixes.size() && fixes[next_].time < motion.begin) ++next_;
  }
  void Advance(core::MonoTime now) {
    const auto& fixes = motion_.recording.fixes;
    for (; next_ < fixes.size() && fixes[next_].time <= motion_.end; ++next_) {
      const RecordedFix& fix = fixes[next_];
      const core::MonoTime mono = clock_.MonoAt(fix.time);
      if (mono > now) return;
      log_.Epoch(fix.time, mono, motion_.antenna_at(fix.time),
                 fix.rtk == core::RtkState::kFixed ? 1 : 2);
    }
  }

 private:
  const MeasuredMotion& motion_;
  const SimClock& clock_;
  TruthLog& log_;
  std::size_t next_ = 0;
};

/// A laser scanner, its cable, and which faults are its own.
struct Scanner {
  Scanner(const ScannerSetup& setup, Pty pty, const MeasuredMotion& motion, const SimClock& clock)
      : instrument(setup.cast, clock, motion.begin, motion.end, setup.options),
        line(std::move(pty), instrument, setup.options.seed + 1) {}
  SickScanner instrument;
  SerialLine line;
};
struct ScannerFaults {
  FaultKind unplug, silent, garbage, stuck, power;
};
constexpr std::array<ScannerFaults, 2> kScannerFaults{
    {{FaultKind::kLaser1Unplug, FaultKind::kLaser1Silent, FaultKind::kLaser1Garbage,
      FaultKind::kLaser1Stuck, FaultKind::kLaser1Power},
     {FaultKind::kLaser2Unplug, FaultKind::kLaser2Silent, FaultKind::kLaser2Garbage,
      FaultKind::kLaser2Stuck, FaultKind::kLaser2Power}}};

void AskForRealTime() {
  sched_param priority{};
  priority.sched_priority = kFifoPriority;
  pthread_setschedparam(pthread_self(), SCHED_FIFO,
                        &priority);  // refused without the right to: paced a little worse
}

}  // namespace

std::string InstrumentSummary::ToText() const {
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
  std::string all = text.data();
  for (std::size_t i = 0; i < scanners.size(); ++i) {
    all += "; laser" + std::to_string(i + 1) + " " + std::to_string(scanners[i].turns) +
           " turns, " + std::to_string(scanners[i].scans) + " scans, " +
           std::to_string(scanners[i].telegrams_in) + " telegrams in (" +
           std::to_string(scanners[i].refused) + " refused)";
  }
  return all;
}

core::Expected<void> PrepareRunDir(const std::filesystem::path& run_dir) {
  std::error_code error;
  std::filesystem::create_directories(run_dir, error);
  if (!error) return {};
  return core::Fail(core::ErrorCode::kIo, "run-dir " + run_dir.string() + ": " + error.message());
}

core::Expected<InstrumentSummary> RunInstruments(const InstrumentOptions& options,
                                                 const MeasuredMotion& motion,
                                                 std::unique_ptr<PictureSource> pictures,
                                                 const std::atomic<bool>& stop) {
  // 1. The places where others find us.
  if (auto made = PrepareRunDir(options.run_dir); !made) return tl::unexpected(made.error());
  std::vector<std::filesystem::path> places;
  for (const char* name : {"gps", "ahrs", "camera.sock", "ready"}) {
    places.push_back(options.run_dir / name);
  }
  for (const ScannerSetup& setup : motion.scanners) places.push_back(options.run_dir / setup.port);
  const Janitor janitor(places);
  core::Expected<TruthLog> truth = TruthLog::Create(options.run_dir);
  if (!truth) return tl::unexpected(truth.error());
  core::Expected<Pty> gps_pty = Pty::Create(options.run_dir / "gps");
  if (!gps_pty) return tl::unexpected(gps_pty.error());
  core::Expected<Pty> ahrs_pty = Pty::Create(options.run_dir / "ahrs");
  if (!ahrs_pty) return tl::unexpected(ahrs_pty.error());

  std::vector<Pty> scanner_ptys;
  for (const ScannerSetup& setup : motion.scanners) {
    core::Expected<Pty> pty = Pty::Create(options.run_dir / setup.port);
    if (!pty) return tl::unexpected(pty.error());
    scanner_ptys.push_back(std::move(*pty));
  }

  // 2. Time starts a moment from now.
  const core::MonoTime begin = core::MonoNow() + core::DurationFromSeconds(options.lead_s);
  const SimClock clock(motion.begin, begin,
                       options.speed * (1.0 + options.machine_skew_ppm * 1e-6));
  const FaultPlan plan(options.faults);
  const auto active = [&](FaultKind kind, core::MonoTime t) {
    return plan.Active(kind, t - begin);
  };

  GpsReceiver gps(motion.recording, clock, motion.begin, motion.end, options.gps);
  Ahrs400 ahrs(motion.trace, clock, motion.begin, motion.end, options.ahrs);
  SerialLine gps_line(std::move(*gps_pty), gps, options.gps.seed + 2);
  SerialLine ahrs_line(std::move(*ahrs_pty), ahrs, options.gps.seed + 3);
  std::vector<std::unique_ptr<Scanner>> scanners;
  for (std::size_t i = 0; i < motion.scanners.size(); ++i) {
    scanners.push_back(
        std::make_unique<Scanner>(motion.scanners[i], std::move(scanner_ptys[i]), motion, clock));
  }
  EpochTruth epoch_truth(motion, clock, *truth);

  std::unique_ptr<CameraServer> camera;
  std::atomic<bool> camera_stop{false};
  std::thread camera_thread;
  if (pictures) {
    CameraServer::Hooks hooks;
    hooks.faults = [&](core::MonoTime t) {
      return CameraServer::Faults{.hang = active(FaultKind::kCameraHang, t),
                                  .miss = active(FaultKind::kCameraMiss, t),
                                  .late = active(FaultKind::kCameraLate, t),
                                  .dark = active(FaultKind::kCameraDark, t),
                                  .disconnected = active(FaultKind::kCameraDisconnect, t)};
    };
    hooks.trigger_pulse = [&](core::MonoTime pulse) { gps.AddEvent(pulse); };
    hooks.exposed = [&](const CameraServer::Exposure& e) {
      truth->Exposure(e.trigger_sequence, e.frame_sequence, e.gps, e.mono, motion.antenna_at(e.gps),
                      motion.yaw_at(e.gps));
    };
    camera = std::make_unique<CameraServer>(options.run_dir / "camera.sock", clock,
                                            std::move(pictures), options.camera, std::move(hooks));
    const core::Expected<void> listening = camera->Listen();
    if (!listening) return tl::unexpected(listening.error());
    camera_thread = std::thread([&] { camera->Run(camera_stop); });
  }
  if (options.realtime) AskForRealTime();
  std::string scanner_devices;
  for (std::size_t i = 0; i < scanners.size(); ++i)
    scanner_devices += "\n" + motion.scanners[i].port + " " + scanners[i]->line.pty().device();
  const ReadyFile ready(options.run_dir / "ready",
                        "pid " + std::to_string(getpid()) + "\ngps " + gps_line.pty().device() +
                            "\nahrs " + ahrs_line.pty().device() + scanner_devices +
                            "\nbegin_gps_ns " + std::to_string(motion.begin.ns()) +
                            "\nbegin_mono_ns " + std::to_string(begin.ns()) + "\nend_gps_ns " +
                            std::to_string(motion.end.ns()) + "\n");
  std::printf("kawara-sim: ready in %s (%.1f s of the drive)\n", options.run_dir.c_str(),
              core::ToSeconds(motion.end - motion.begin));
  std::fflush(stdout);

  // 3. Time passes. The last sentences get half a second to leave.
  const core::MonoTime end = clock.MonoAt(motion.end) + core::Milliseconds(500);
  InstrumentSummary summary;
  core::Expected<void> healthy;
  core::MonoTime now = core::MonoNow();
  while (!stop.load() && now < end && healthy) {
    gps.SetFaults({.no_fix = active(FaultKind::kGpsNoFix, now),
                   .bad_checksum = active(FaultKind::kGpsBadSum, now),
                   .power_off = active(FaultKind::kGpsPower, now),
                   .clock_step = active(FaultKind::kGpsClockStep, now),
                   .no_pps = active(FaultKind::kGpsNoPps, now)});
    ahrs.SetClockStep(active(FaultKind::kAhrsClockStep, now));
    healthy = gps_line.Service(now, {.unplugged = active(FaultKind::kGpsUnplug, now),
                                     .silent = active(FaultKind::kGpsSilent, now),
                                     .garbage = active(FaultKind::kGpsGarbage, now),
                                     .stuck = active(FaultKind::kGpsStuck, now)});
    if (healthy) {
      healthy = ahrs_line.Service(now, {.unplugged = active(FaultKind::kAhrsUnplug, now),
                                        .silent = active(FaultKind::kAhrsSilent, now),
                                        .garbage = active(FaultKind::kAhrsGarbage, now),
                                        .stuck = active(FaultKind::kAhrsStuck, now)});
    }
    SerialLine::Faults scanner_faults;
    for (std::size_t i = 0; i < scanners.size() && healthy; ++i) {
      if (i < kScannerFaults.size()) {
        const ScannerFaults& own = kScannerFaults[i];
        scanner_faults = {.unplugged = active(own.unplug, now),
                          .silent = active(own.silent, now),
                          .garbage = active(own.garbage, now),
                          .stuck = active(own.stuck, now)};
        scanners[i]->instrument.SetPower(now, !active(own.power, now));
      } else {
        scanner_faults = {};
      }
      healthy = scanners[i]->line.Service(now, scanner_faults);
    }
    epoch_truth.Advance(now);
    core::MonoTime wake = std::min(now + kLongestSleep, end);
    const auto consider = [&wake](core::MonoTime due) {
      if (due.IsSet()) wake = std::min(wake, due);
    };
    consider(gps_line.NextService());
    consider(ahrs_line.NextService());
    for (const auto& scanner : scanners) consider(scanner->line.NextService());
    SleepUntil(wake);
    now = core::MonoNow();
    summary.latest_wakeup = std::max(summary.latest_wakeup, now - wake);
  }

  // 4. Everything down again.
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
  for (const auto& scanner : scanners) summary.scanners.push_back(scanner->instrument.counters());
  return summary;
}

}  // namespace kawara::sim
