/// kawara-station: takes what the robot sends into the spatial temporal GIS.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "comms/event_log_reader.hpp"
#include "comms/lcm_bus.hpp"
#include "comms/log_bus.hpp"
#include "core/config/config.hpp"
#include "gis/dump.hpp"
#include "gis/kiwi/change_overlay.hpp"
#include "gis/track_map.hpp"
#include "station/station.hpp"

namespace {

using namespace kawara;

std::atomic<bool> g_stop{false};
extern "C" void OnSignal(int /*number*/) { g_stop = true; }

struct Arguments {
  std::string config;
  std::vector<std::string> set;
  std::string store;
  std::string pictures;
  std::string lcm_url;
  std::vector<std::string> logs;
  std::string latency;
  std::string map;
  std::string dump;
  station::RunLimits limits;
};

void Say(const std::string& line) { std::fprintf(stderr, "kawara-station: %s\n", line.c_str()); }

int Complain(const core::Error& error, int code) {
  Say(error.message);
  return code;
}

core::Expected<station::StationConfig> LoadConfig(const Arguments& args) {
  auto config = args.config.empty()
                    ? core::config::Parse<station::StationConfig>("{}", "defaults", args.set)
                    : core::config::Load<station::StationConfig>(args.config, args.set);
  if (!config) return config;
  if (!args.store.empty()) config->store.target = args.store;
  if (!args.pictures.empty()) config->store.pictures_dir = args.pictures;
  if (!args.lcm_url.empty()) config->lcm_url = args.lcm_url;
  return config;
}

core::Expected<std::unique_ptr<comms::Bus>> OpenBus(const Arguments& args,
                                                    const station::StationConfig& config) {
  if (!args.logs.empty()) {
    auto reader = comms::EventLogReader::Open({args.logs.begin(), args.logs.end()});
    if (!reader) return tl::unexpected(reader.error());
    return std::make_unique<comms::LogBus>(std::move(*reader));
  }
  auto bus = comms::LcmBus::Open({.url = config.lcm_url});
  if (!bus) return tl::unexpected(bus.error());
  for (const std::string& warning : (*bus)->warnings()) Say(warning);
  return std::move(*bus);
}

int Run(const Arguments& args) {
  const auto config = LoadConfig(args);
  if (!config) return Complain(config.error(), 2);
  const gis::StoreConfig target{
      .target = config->store.target,
      .pictures_dir = config->store.pictures_dir,
      .max_pending_bytes = std::size_t{1} << 40};  // the queue is the bound
  auto feeder = station::StoreFeeder::Create(target, args.latency, Say);
  if (!feeder) return Complain(feeder.error(), 2);
  const bool live = args.logs.empty();
  if (auto open = feeder->Connect(); !open) {
    if (!live || open.error().code != core::ErrorCode::kUnavailable)
      return Complain(open.error(), 2);
    Say(open.error().message + "; listening and trying again");
  }
  auto bus = OpenBus(args, *config);
  if (!bus) return Complain(bus.error(), 2);
  station::Station base(*config, std::move(*feeder), Say);
  const auto ran = live ? base.RunLive(**bus, args.limits, g_stop) : base.RunLog(**bus, g_stop);
  std::printf("kawara-station: %s: %s\n", config->store.target.c_str(), base.Summary().c_str());
  if (!ran) return Complain(ran.error(), 1);
  if (args.map.empty()) return 0;
  const auto changes = gis::LoadChangeOverlay(config->store.target);
  if (!changes) return Complain(changes.error(), 1);
  const auto drawn = gis::DrawTrackMap(config->store.target, args.map, {}, *changes);
  return drawn ? 0 : Complain(drawn.error(), 1);
}

int Dump(const Arguments& args) {
  const auto dumped = gis::DumpStore(args.dump, args.pictures, std::cout);
  return dumped ? 0 : Complain(dumped.error(), 1);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments args;
  CLI::App app("Takes the robot's pictures, poses and events into a spatial temporal GIS.");
  app.add_option("--config", args.config, "station YAML (configs/station.yaml)");
  app.add_option("--set", args.set, "key=value, over the file; repeatable")
      ->allow_extra_args(false);
  app.add_option("--store", args.store, "GeoPackage file, or \"PG:dbname=...\" for PostGIS");
  app.add_option("--pictures", args.pictures,
                 "folder of the JPEG files (pictures beside the store)");
  app.add_option("--lcm-url", args.lcm_url, "live bus (LCM's default group)");
  app.add_option("--log", args.logs, "work from this log file or folder instead of the live bus")
      ->allow_extra_args(false);
  app.add_option("--latency", args.latency, "CSV: when each picture became durable");
  app.add_option("--map", args.map, "PNG map of the tracks and of what changed, drawn at the end");
  app.add_option("--duration", args.limits.duration_s, "end after so many seconds");
  app.add_option("--idle-exit", args.limits.idle_exit_s, "end after so many seconds of silence");
  app.add_option("--dump", args.dump, "print everything this store says, in one order, and end");
  CLI11_PARSE(app, argc, argv);

  struct sigaction action {};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGXFSZ, SIG_IGN);  // a file size limit is answered like a full disk
  signal(SIGPIPE, SIG_IGN);
  return args.dump.empty() ? Run(args) : Dump(args);
}
