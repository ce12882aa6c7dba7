// Cost of the navigation filter: one inertial sample, one RTK position, doing a late measurement's
// third of a second again, and smoothing. Goals on one core: 6, 15, 250 us; 21 min at 75 Hz
// smoothed in 3 s, which is 32 us a sample.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "estimation/filter_tape.hpp"
#include "estimation/measurement_models.hpp"
#include "estimation/navigation_filter.hpp"
#include "estimation/navigator.hpp"
#include "estimation/smoother.hpp"
#include "tests/support/drive_recording.hpp"

namespace {

namespace core = kawara::core;
namespace estimation = kawara::estimation;
using kawara::testing::DriveRecording;

kawara::testing::DriveSensors Sensors() {
  kawara::testing::DriveSensors sensors;
  sensors.imu = *estimation::FindSensorProfile("ahrs400cc-100");
  return sensors;
}

const DriveRecording& Drive() {
  static const DriveRecording drive = kawara::testing::Record({.duration_s = 120.0}, Sensors(), 1);
  return drive;
}

const estimation::NavigationConfig& Config() {
  static const estimation::NavigationConfig config = kawara::testing::ConfigOf(Sensors());
  return config;
}

void Add(estimation::Navigator& navigator, const DriveRecording::Arrival& arrival) {
  switch (arrival.kind) {
    case DriveRecording::Kind::kFix:
      navigator.AddFix(Drive().fixes[arrival.index]);
      break;
    case DriveRecording::Kind::kWheels:
      navigator.AddOdometry(Drive().wheels[arrival.index]);
      break;
    case DriveRecording::Kind::kImu:
      navigator.AddImu(Drive().imu[arrival.index]);
      break;
  }
}

/// A filter in the middle of the drive.
const estimation::ErrorStateFilter& Running() {
  static const estimation::ErrorStateFilter filter = [] {
    estimation::Navigator navigator(Config());
    for (const auto& arrival : Drive().InOrder()) Add(navigator, arrival);
    return navigator.filter()->errors();
  }();
  return filter;
}

estimation::ImuInterval Interval() {
  const auto& sample = Drive().imu[5000];
  const auto& before = Drive().imu[4999];
  return {.duration_s = 1.0 / 75.0,
          .rate_radps = sample.rate_radps,
          .specific_force_mps2 = sample.specific_force_mps2,
          .previous_rate_radps = before.rate_radps,
          .previous_specific_force_mps2 = before.specific_force_mps2};
}

/// Of this thread's own work: other programs on the machine do not count.
double ThreadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void NavigationPredict(benchmark::State& state) {
  estimation::ErrorStateFilter filter = Running();
  const estimation::ImuInterval imu = Interval();
  int steps = 0;
  for (auto _ : state) {
    filter.Propagate(imu, 1.0 / 75.0, Config().imu, false);
    if (++steps % 1000 == 0) filter = Running();
  }
  benchmark::DoNotOptimize(filter);
}
BENCHMARK(NavigationPredict)->Unit(benchmark::kMicrosecond);

void NavigationRtkUpdate(benchmark::State& state) {
  estimation::ErrorStateFilter filter = Running();
  core::GnssFix fix = Drive().fixes.back();
  const estimation::BodyMotion motion{.rate_radps = {0.01, 0.02, 0.3},
                                      .acceleration_mps2 = {0.5, 0.2, 0.0}};
  for (auto _ : state) {
    const auto rows = estimation::PositionRows(filter.state(), motion, fix, 0.0, Config());
    const auto innovation = filter.Predict(rows);
    filter.Update(rows, innovation);
  }
  benchmark::DoNotOptimize(filter);
}
BENCHMARK(NavigationRtkUpdate)->Unit(benchmark::kMicrosecond);

/// A drive in which every fix comes 0.35 s late: time of the AddFix that goes back, on average.
void NavigationReplay350ms(benchmark::State& state) {
  std::vector<DriveRecording::Arrival> order = Drive().InOrder();
  for (auto& arrival : order) {
    if (arrival.kind == DriveRecording::Kind::kFix) arrival.t_s += 0.35;
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  for (auto _ : state) {
    estimation::Navigator navigator(Config());
    double seconds = 0.0;
    int replays = 0;
    for (const auto& arrival : order) {
      if (arrival.kind != DriveRecording::Kind::kFix || navigator.filter() == nullptr) {
        Add(navigator, arrival);
        continue;
      }
      const double begin_s = ThreadSeconds();
      Add(navigator, arrival);
      seconds += ThreadSeconds() - begin_s;
      ++replays;
    }
    state.SetIterationTime(seconds / replays);
  }
}
BENCHMARK(NavigationReplay350ms)->UseManualTime()->Iterations(5)->Unit(benchmark::kMicrosecond);

/// Everything in order, per inertial sample: what a log costs.
void NavigationInOrder(benchmark::State& state) {
  const auto order = Drive().InOrder();
  for (auto _ : state) {
    estimation::Navigator navigator(Config());
    for (const auto& arrival : order) Add(navigator, arrival);
    benchmark::DoNotOptimize(navigator.Latest());
  }
  state.counters["per_sample"] = benchmark::Counter(
      static_cast<double>(Drive().imu.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(NavigationInOrder)->Unit(benchmark::kMillisecond);

void NavigationSmoothing(benchmark::State& state) {
  estimation::FilterTape tape;
  estimation::Navigator navigator(Config());
  navigator.Record(&tape);
  for (const auto& arrival : Drive().InOrder()) Add(navigator, arrival);
  std::size_t nodes = 0;
  for (auto _ : state) {
    nodes = 0;
    estimation::Smooth(tape, [&](const estimation::NavSolution& solution) {
      benchmark::DoNotOptimize(solution.position.lat_rad);
      ++nodes;
      return true;
    });
  }
  state.counters["per_sample"] =
      benchmark::Counter(static_cast<double>(nodes), benchmark::Counter::kIsIterationInvariantRate |
                                                         benchmark::Counter::kInvert);
}
BENCHMARK(NavigationSmoothing)->Unit(benchmark::kMillisecond);

}  // namespace
