#include <benchmark/benchmark.h>

#include <cmath>

#include "core/config/config.hpp"
#include "sim/vehicle/simulate_drive.hpp"
#include "sim/vehicle/true_inertial.hpp"

namespace kawara::sim {
namespace {

DriveScenario TwoMinutes() {
  DriveScenario scenario;
  scenario.origin = {35.36 * core::kRadFromDeg, 139.53 * core::kRadFromDeg, 52.0};
  scenario.begin = core::FromWeek({.week = 2391, .time_of_week = core::Seconds(7200)});
  scenario.robot =
      config::Load<RobotModel>(KAWARA_SOURCE_DIR "/configs/vehicles/survey_robot.yaml").value();
  scenario.path.waypoints = {{0, 0, {}, 0}, {45, 0, {}, 0}, {45, 30, {}, 2}, {40, 40, {}, 0}};
  return scenario;
}
double Hills(double east_m, double north_m) { return 0.02 * east_m + 0.1 * std::sin(north_m); }
bool House(const Eigen::Vector3d& /*enu_m*/, double azimuth_rad, double elevation_rad) {
  return std::cos(azimuth_rad) > 0.5 && elevation_rad < 0.7;
}

/// Everything that all sensors measure on a drive of some two minutes: inertial 100 Hz, receiver 10
/// Hz, wheels 20 Hz.
void SimulateTwoMinutes(benchmark::State& state) {
  const DriveScenario scenario = TwoMinutes();
  double seconds = 0.0;
  for (auto _ : state) {
    auto drive = SimulateDrive(scenario, {Hills, House, {}});
    seconds = core::ToSeconds(drive->recording.end() - drive->recording.begin());
    benchmark::DoNotOptimize(drive);
  }
  state.counters["drive_s"] = seconds;
}
BENCHMARK(SimulateTwoMinutes)->Unit(benchmark::kMillisecond);

void StateAtAnInstant(benchmark::State& state) {
  const DriveScenario s = TwoMinutes();
  const Trajectory t =
      Trajectory::Make(s.robot.vehicle, s.path, s.origin, s.begin, Hills, 1).value();
  double at_s = 0.0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(t.AtSeconds(at_s));
    at_s = at_s > 100.0 ? 0.0 : at_s + 0.0137;
  }
}
BENCHMARK(StateAtAnInstant);

}  // namespace
}  // namespace kawara::sim
