// Cost of what the real-time thread calls for every epoch and every attitude sample.
#include <benchmark/benchmark.h>

#include "estimation/pose_composer.hpp"

namespace {

namespace core = kawara::core;
namespace estimation = kawara::estimation;

constexpr std::int64_t kGpsStart = 1'400'000'000'000'000'000;

core::GnssFix FixAt(std::int64_t ns) {
  core::GnssFix fix;
  fix.time = core::GpsTime::FromNs(kGpsStart + ns);
  fix.has_position = true;
  fix.antenna = core::OffsetNed({0.667, 2.458, 60.0}, {5e-9 * static_cast<double>(ns), 0.0, 0.0});
  fix.position_cov_enu_m2.setIdentity();
  fix.has_velocity = true;
  fix.velocity_enu_mps << 0.0, 5.0, 0.0;
  return fix;
}

void EnvelopeAdd(benchmark::State& state) {
  estimation::EnvelopeClock clock;
  std::int64_t ns = 0;
  for (auto _ : state) {
    ns += 100'000'000;
    const std::int64_t jitter = ns / 100'000'000 * 7919 % 20'000'000;
    clock.Add(estimation::StreamTime::FromNs(kGpsStart + ns), core::MonoTime::FromNs(ns + jitter));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(EnvelopeAdd);

void PoseAtAhrsRate(benchmark::State& state) {
  estimation::GpsTimeline clock;
  estimation::PoseComposer composer;
  core::AhrsSample sample;
  sample.has_attitude = true;
  std::int64_t ns = 1'000'000'000;
  std::int64_t next_fix_ns = ns;
  for (auto _ : state) {
    ns += 16'666'667;
    if (ns >= next_fix_ns + 50'000'000) {
      clock.AddEpoch(core::GpsTime::FromNs(kGpsStart + next_fix_ns),
                     core::MonoTime::FromNs(next_fix_ns + 50'000'000));
      composer.AddFix(FixAt(next_fix_ns), clock);
      next_fix_ns += 100'000'000;
    }
    sample.sampled = core::MonoTime::FromNs(ns);
    benchmark::DoNotOptimize(composer.AddAhrsAndCompose(sample, clock));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(PoseAtAhrsRate);

}  // namespace
