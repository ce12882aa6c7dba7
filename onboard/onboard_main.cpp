// kawara-onboard: reads GPS, AHRS and camera, estimates the pose, sends phase 1, records
// everything; or does the same again from a log.
#include <pthread.h>
#include <signal.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "comms/event_log_writer.hpp"
#include "core/config/config.hpp"
#include "onboard/check/computer_check.hpp"
#include "onboard/check/device_check.hpp"
#include "onboard/live_robot.hpp"
#include "onboard/replay_robot.hpp"
#include "onboard/service_manager.hpp"

namespace {

using namespace kawara;  // NOLINT(google-build-using-namespace): the program's own

struct Options {
  std::string config_path;
  std::vector<std::string> overrides;
  std::vector<std::string> logs;
  std::string out;
  double duration_s = 0.0;
  bool check_config = false;
  bool check = false;
};

int Complain(const core::Error& error) {
  std::fprintf(stderr, "kawara-onboard: %s\n", error.message.c_str());
  return 2;
}

/// Signals are taken by sigtimedwait() in main; threads inherit the mask.
sigset_t BlockSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return signals;
}

/// Meanwhile the service manager hears that the robot lives, for as long as it does.
void WaitForSignal(const sigset_t& signals, double duration_s, onboard::LiveRobot& robot) {
  const core::MonoTime end = core::MonoNow() + core::DurationFromSeconds(duration_s);
  const std::int64_t nap_ns = onboard::service::AlivePeriod(core::Seconds(1)).count();
  const timespec nap{nap_ns / 1'000'000'000, nap_ns % 1'000'000'000};
  for (;;) {
    if (sigtimedwait(&signals, nullptr, &nap) > 0) return;
    if (robot.IsAlive()) onboard::service::SayAlive();
    if (duration_s > 0.0 && core::MonoNow() >= end) return;
  }
}

int RunLive(const onboard::OnboardConfig& config, double duration_s) {
  const sigset_t signals = BlockSignals();
  auto robot = onboard::LiveRobot::Start(config);
  if (!robot) return Complain(robot.error());
  onboard::service::SayReady();
  WaitForSignal(signals, duration_s, **robot);
  onboard::service::SayStopping();
  (*robot)->Stop();
  std::printf("%s\n", (*robot)->Summary().c_str());
  return 0;
}

/// 0: nothing is wrong; 1: something is.
int RunCheck(const onboard::OnboardConfig& config) {
  static constexpr const char* kWords[] = {"good ", "weak ", "WRONG"};
  int counts[3] = {};
  for (const auto check :
       {+[](const onboard::OnboardConfig& c) { return onboard::CheckComputer(c); },
        &onboard::CheckDevices}) {
    for (const onboard::Finding& finding : check(config)) {
      const auto verdict = static_cast<std::size_t>(finding.verdict);
      ++counts[verdict];
      std::printf("%s  %s: %s\n", kWords[verdict], finding.subject.c_str(), finding.text.c_str());
      std::fflush(stdout);
    }
  }
  std::printf("kawara-onboard: %d good, %d weak, %d wrong\n", counts[0], counts[1], counts[2]);
  return counts[2] > 0 ? 1 : 0;
}

core::Expected<onboard::OnboardConfig> ConfigFor(const Options& options,
                                                 const std::vector<std::filesystem::path>& paths) {
  if (!options.config_path.empty()) {
    return core::config::Load<onboard::OnboardConfig>(options.config_path, options.overrides);
  }
  return comms::EventLogReader::Open(paths).and_then(
      [](comms::EventLogReader reader) { return onboard::ReplayRobot::RecordedConfig(reader); });
}

int RunReplay(const Options& options) {
  const std::vector<std::filesystem::path> paths(options.logs.begin(), options.logs.end());
  const auto config = ConfigFor(options, paths);
  if (!config) return Complain(config.error());
  auto reader = comms::EventLogReader::Open(paths);
  if (!reader) return Complain(reader.error());
  comms::LogWriterOptions writer_options;
  writer_options.fdatasync = false;  // a copy: it can be made again
  auto writer = comms::EventLogWriter::Create(options.out, writer_options);
  if (!writer) return Complain(writer.error());

  core::Expected<void> written;
  core::MonoTime now;  // the writer's sync time line: of no use here, and no clock is read
  const auto stats = onboard::ReplayRobot::Play(
      *reader, *config,
      [&](std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t time_us) {
        if (!written) return;
        now = core::MonoTime::FromNs(time_us * 1000);
        written = writer->Append(time_us, channel, bytes, now);
      });
  if (!stats) return Complain(stats.error());
  if (written) written = writer->Close();
  if (!written) return Complain(written.error());
  std::printf(
      "kawara-onboard: replayed %lld inputs: %lld fixes, %lld poses, %lld pictures, %lld events; "
      "%llu damaged places in the log; output: %s\n",
      static_cast<long long>(stats->inputs), static_cast<long long>(stats->fixes),
      static_cast<long long>(stats->poses), static_cast<long long>(stats->pictures),
      static_cast<long long>(stats->events),
      static_cast<unsigned long long>(reader->stats().damage_count), options.out.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "kawara-onboard: reads GPS receiver, attitude unit and omnidirectional camera, sends the 1st "
      "update (pose and picture of every selected epoch) over LCM and records everything; with "
      "--log it does the same again from a recording."};
  Options options;
  app.add_option("--config,-c", options.config_path, "the robot's YAML (see configs/)");
  app.add_option("--set", options.overrides,
                 "key=value over the configuration, e.g. gps.device=/dev/ttyUSB0");
  app.add_option("--log", options.logs,
                 "replay these logs (files or folders) instead of running live");
  app.add_option("--out", options.out, "where the replay's messages go (an LCM event log)");
  app.add_option("--duration", options.duration_s, "live: stop after so many seconds")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--check-config", options.check_config, "print the complete configuration and stop");
  app.add_flag("--check", options.check,
               "look at this computer and the instruments of the configuration, say what is wrong "
               "and how to mend it, and stop");
  app.set_version_flag("--version", KAWARA_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  }
  if (!options.logs.empty()) {
    if (options.out.empty()) {
      std::fprintf(stderr, "kawara-onboard: --log needs --out FILE for what the replay says\n");
      return 2;
    }
    return RunReplay(options);
  }
  if (options.config_path.empty()) {
    std::fprintf(stderr,
                 "kawara-onboard: give the robot's configuration with --config (examples are in "
                 "configs/), or a recording with --log\n");
    return 2;
  }
  const auto config =
      core::config::Load<onboard::OnboardConfig>(options.config_path, options.overrides);
  if (!config) return Complain(config.error());
  if (options.check_config) {
    std::fputs(onboard::PublicYaml(*config).c_str(), stdout);
    return 0;
  }
  if (options.check) return RunCheck(*config);
  return RunLive(*config, options.duration_s);
}
