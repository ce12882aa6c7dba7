#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "core/config/config.hpp"
#include "sim/motion/ahrs_trace.hpp"
#include "sim/motion/motion_track.hpp"
#include "sim/virtual/virtual_run.hpp"
#include "sim/world/site_world.hpp"

namespace kawara::sim {
namespace {

constexpr std::int64_t kDrive_s = 60;

/// The simulated robot without its camera, and the robot's own core reading it: receiver at 10 Hz,
/// pulses, attitude unit at 100 Hz, all their bytes, the log. What a second of it costs is what a
/// second of a live run costs on one core, but for sleeping and waking.
void RobotWithoutCamera(benchmark::State& state) {
  const auto world =
      SiteWorld::Create({.site = KAWARA_SOURCE_DIR "/configs/sites/factory_road.yaml",
                         .robot = KAWARA_SOURCE_DIR "/configs/vehicles/survey_robot.yaml",
                         .set = {},
                         .lit = false,
                         .light = {},
                         .begin = core::ToGps(core::FromCivil({2026, 1, 17, 5, 46, 52}))});
  auto onboard =
      core::config::Load<onboard::OnboardConfig>(KAWARA_SOURCE_DIR "/configs/survey_robot.yaml");
  if (!world || !onboard) {
    const std::string what = world ? onboard.error().message : world.error().message;
    return state.SkipWithError(what.c_str());
  }
  onboard->camera.source = "none";
  const Recording& recording = (*world)->recording();
  const std::vector<AhrsState> trace = MakeAhrsTrace(recording, MotionTrack(recording), 1);
  const Trajectory& way = (*world)->trajectory();
  const MeasuredMotion motion{recording,
                              trace,
                              recording.begin(),
                              recording.begin() + core::Seconds(kDrive_s),
                              [&way](core::GpsTime t) {
                                return way.GeodeticAt(t, {0, 0, 0});
                              },
                              [&way](core::GpsTime t) { return way.AttitudeAt(t).yaw_rad; }};
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("kawara-bench-" + std::to_string(getpid()));
  const std::atomic<bool> stop{false};
  for (auto _ : state) {
    state.PauseTiming();
    std::filesystem::remove_all(folder);
    state.ResumeTiming();
    InstrumentOptions instruments;
    instruments.run_dir = folder / "run";
    const auto done =
        RunVirtual(instruments, {folder / "mission.lcm", *onboard}, motion, nullptr, stop);
    if (!done) return state.SkipWithError(done.error().message.c_str());
  }
  std::filesystem::remove_all(folder);
  using benchmark::Counter;
  state.counters["cpu_s/s"] = Counter(static_cast<double>(kDrive_s * state.iterations()),
                                      Counter::kIsRate | Counter::kInvert);
}
BENCHMARK(RobotWithoutCamera)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kawara::sim
