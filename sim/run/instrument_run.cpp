#include "sim/run/instrument_run.hpp"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <thread>

#include "sim/ports/janitor.hpp"
#include "sim/ports/pps_server.hpp"
#include "sim/ports/pty.hpp"
#include "sim/ports/sleep_until.hpp"
#include "sim/run/truth_log.hpp"

namespace kawara::sim {
namespace {

/// Host's commands and camera pulses are looked at this often when nothing else is due.
constexpr core::Duration kLongestSleep = core::Milliseconds(2);
constexpr int kFifoPriority = 30;

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

/// The camera's socket and thread; neither before Start().
class CameraThread {
 public:
  CameraThread() = default;
  ~CameraThread() { Stop(); }
  CameraThread(const CameraThread&) = delete;
  CameraThread& operator=(const CameraThread&) = delete;

  /// `clock` and `instruments` must outlive it.
  core::Expected<void> Start(const InstrumentOptions& options, const SimClock& clock,
                             std::unique_ptr<PictureSource> pictures, InstrumentSet& instruments) {
    CameraServer::Hooks hooks;
    hooks.faults = [&instruments](core::MonoTime /*now*/) { return instruments.camera_faults(); };
    hooks.signal = [&instruments](core::MonoTime t) { instruments.OnCameraSignal(t); };
    hooks.exposed = [&instruments](const CameraServer::Exposure& e) { instruments.OnExposure(e); };
    server_ = std::make_unique<CameraServer>(options.run_dir / "camera.sock", clock,
                                             std::move(pictures), options.camera, std::move(hooks));
    if (auto listening = server_->Listen(); !listening) return listening;
    thread_ = std::thread([this] { server_->Run(stop_); });
    return {};
  }
  void Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  CameraServer::Counters counters() const {
    return server_ ? server_->counters() : CameraServer::Counters{};
  }

 private:
  std::unique_ptr<CameraServer> server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

core::Expected<InstrumentSet::Ports> OpenPorts(const std::filesystem::path& run_dir,
                                               const MeasuredMotion& motion) {
  InstrumentSet::Ports ports;
  const auto open = [&run_dir](const std::string& name, std::unique_ptr<HostPort>& port) {
    return Pty::Create(run_dir / name).map([&port](Pty pty) {
      port = std::make_unique<Pty>(std::move(pty));
    });
  };
  if (auto ok = open("gps", ports.gps); !ok) return tl::unexpected(ok.error());
  if (auto ok = open("ahrs", ports.ahrs); !ok) return tl::unexpected(ok.error());
  for (const ScannerSetup& setup : motion.scanners) {
    if (auto ok = open(setup.port, ports.scanners.emplace_back()); !ok)
      return tl::unexpected(ok.error());
  }
  return ports;
}

void AskForRealTime() {
  sched_param priority{};
  priority.sched_priority = kFifoPriority;
  pthread_setschedparam(pthread_self(), SCHED_FIFO,
                        &priority);  // refused without the right to: paced a little worse
}

}  // namespace

std::string InstrumentSummary::ToText() const {
  const InstrumentSet::Counters& i = instruments;
  std::array<char, 640> text{};
  std::snprintf(
      text.data(), text.size(),
      "kawara-sim: %.1f s%s; gps %llu epochs, %llu sentences, %llu commands (%llu refused), %llu "
      "rtcm, "
      "%llu overrun bytes, %llu dropped messages; pps %llu edges; ahrs %llu samples, %llu packets, "
      "%llu skipped, "
      "%llu saturated, %llu overrun bytes; camera %llu triggers, %llu frames, %llu missed, %llu "
      "lost, %llu drawn late, "
      "slowest %.1f ms; pacing at most %.1f ms late",
      ran_s, stopped_early ? " (stopped)" : "", static_cast<unsigned long long>(i.gps.epochs),
      static_cast<unsigned long long>(i.gps.sentences),
      static_cast<unsigned long long>(i.gps.commands),
      static_cast<unsigned long long>(i.gps.refused),
      static_cast<unsigned long long>(i.gps.rtcm_messages),
      static_cast<unsigned long long>(i.gps_line.overrun_bytes),
      static_cast<unsigned long long>(i.gps_dropped_messages),
      static_cast<unsigned long long>(i.pulses), static_cast<unsigned long long>(i.ahrs.samples),
      static_cast<unsigned long long>(i.ahrs.packets),
      static_cast<unsigned long long>(i.ahrs.skipped),
      static_cast<unsigned long long>(i.ahrs_saturated),
      static_cast<unsigned long long>(i.ahrs_line.overrun_bytes),
      static_cast<unsigned long long>(camera.triggers),
      static_cast<unsigned long long>(camera.frames),
      static_cast<unsigned long long>(camera.missed), static_cast<unsigned long long>(camera.lost),
      static_cast<unsigned long long>(camera.made_late),
      core::ToSeconds(camera.longest_delivery) * 1e3, core::ToSeconds(latest_wakeup) * 1e3);
  std::string all = text.data();
  for (std::size_t n = 0; n < i.scanners.size(); ++n) {
    const SickScanner::Counters& scanner = i.scanners[n];
    all += "; laser" + std::to_string(n + 1) + " " + std::to_string(scanner.turns) + " turns, " +
           std::to_string(scanner.scans) + " scans, " + std::to_string(scanner.telegrams_in) +
           " telegrams in (" + std::to_string(scanner.refused) + " refused)";
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
  for (const char* name : {"gps", "ahrs", "pps.sock", "camera.sock", "ready"}) {
    places.push_back(options.run_dir / name);
  }
  for (const ScannerSetup& setup : motion.scanners) places.push_back(options.run_dir / setup.port);
  const Janitor janitor(places);
  core::Expected<TruthLog> truth = TruthLog::Create(options.run_dir, motion.world, motion.begin);
  if (!truth) return tl::unexpected(truth.error());
  auto ports = OpenPorts(options.run_dir, motion);
  if (!ports) return tl::unexpected(ports.error());
  PpsServer pulses(options.run_dir / "pps.sock");
  if (auto listening = pulses.Listen(); !listening) return tl::unexpected(listening.error());
  ports->pulses = [&pulses](const drivers::PpsEdge& edge) { pulses.Send(edge); };

  // 2. Time starts a moment from now.
  const core::MonoTime begin = core::MonoNow() + core::DurationFromSeconds(options.lead_s);
  const SimClock clock(motion.begin, begin,
                       options.speed * (1.0 + options.machine_skew_ppm * 1e-6));
  InstrumentSet instruments(options, motion, clock, begin, std::move(*ports), *truth);
  CameraThread camera;
  if (pictures) {
    const auto listening = camera.Start(options, clock, std::move(pictures), instruments);
    if (!listening) return tl::unexpected(listening.error());
  }
  FaultOrderInbox orders;
  std::unique_ptr<FaultListener> listener;
  if (options.lcm_url) {
    auto started = FaultListener::Start(*options.lcm_url, options.command_channel, begin,
                                        IsInstrumentFault, orders);
    if (!started) return tl::unexpected(started.error());
    listener = std::move(*started);
  }
  if (options.realtime) AskForRealTime();
  const ReadyFile ready(options.run_dir / "ready",
                        "pid " + std::to_string(getpid()) + "\n" + instruments.DevicesText() +
                            "begin_gps_ns " + std::to_string(motion.begin.ns()) +
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
  while (!stop.load() && now < end) {
    for (const FaultOrder& order : orders.Take(instruments.planned_faults())) {
      instruments.Take(now, order);
    }
    healthy = instruments.Service(now);
    if (!healthy) break;
    core::MonoTime wake = std::min(now + kLongestSleep, end);
    if (const core::MonoTime due = instruments.NextService(); due.IsSet())
      wake = std::min(wake, due);
    SleepUntil(wake);
    now = core::MonoNow();
    summary.latest_wakeup = std::max(summary.latest_wakeup, now - wake);
  }

  // 4. Everything down again.
  listener.reset();
  camera.Stop();
  if (healthy) healthy = instruments.Service(now);  // exposures of the last moment
  if (healthy) healthy = instruments.FinishTruth(now);
  if (!healthy) return tl::unexpected(healthy.error());
  summary.ran_s = core::ToSeconds(std::min(now, end) - begin);
  summary.stopped_early = now < end;
  summary.instruments = instruments.counters();
  summary.camera = camera.counters();
  return summary;
}

}  // namespace kawara::sim
