#include "sim/site_run.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>

#include "sim/render/range_scan.hpp"
#include "sim/world/world_truth.hpp"

namespace kawara::sim {
namespace {

/// Pictures that take a smaller share of the time between them are drawn while the robot drives:
/// so much is left for the robot's own programs on the same machine.
constexpr double kLiveShare = 0.4;

core::GpsTime GpsNow() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return core::ToGps(core::UtcTime::FromNs(std::int64_t{now.tv_sec} * 1'000'000'000));
}

/// What lies between `start_s` and the end asked for.
core::Expected<std::pair<core::GpsTime, core::GpsTime>> Span(const Recording& recording,
                                                             const SiteRunOptions& options) {
  const double all_s = core::ToSeconds(recording.end() - recording.begin());
  if (!(options.start_s >= 0.0 && options.start_s < all_s)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "--start " + std::to_string(options.start_s) + ": the drive takes " +
                          std::to_string(all_s) + " s");
  }
  const core::GpsTime begin = recording.begin() + core::DurationFromSeconds(options.start_s);
  const double wanted_s = std::min(options.duration_s.value_or(all_s), all_s - options.start_s);
  return std::pair{begin, begin + core::DurationFromSeconds(wanted_s)};
}

/// The laser scanners, which see the world's surfaces. The rays' own noise is left to the
/// instrument.
std::vector<ScannerSetup> Scanners(const SiteWorld& world, std::uint64_t seed) {
  RangeScannerSettings settings;
  settings.noise_m = settings.noise_share = settings.resolution_m = 0.0;
  std::vector<ScannerSetup> setups;
  for (const ScannerMount& mount : world.robot().vehicle.scanners) {
    const std::uint64_t own_seed = seed + 20 + setups.size();
    SickScannerOptions options;  // its range noise is the one that counts
    options.seed = own_seed;
    setups.push_back(
        {mount.name,
         [&world, mount, own_seed, scanner = RangeScanner(settings)](core::GpsTime ahead,
                                                                     std::span<float> ranges_m) {
           const auto pose = [&](double seconds) {
             return world.EnuFromScanner(mount, ahead + core::DurationFromSeconds(seconds));
           };
           const auto beams = scanner.Scan(world.rays(), pose, world.MissionSeconds(ahead),
                                           own_seed + static_cast<std::uint64_t>(ahead.ns()));
           for (std::size_t i = 0; i < ranges_m.size() && i < beams.size(); ++i) {
             ranges_m[i] = beams[i].echo ? static_cast<float>(beams[i].range_m)
                                         : std::numeric_limits<float>::infinity();
           }
         },
         options});
  }
  return setups;
}

}  // namespace

core::Expected<InstrumentSummary> RunSite(SiteRunOptions options, const std::atomic<bool>& stop) {
  if (auto made = PrepareRunDir(options.instruments.run_dir); !made) {
    return tl::unexpected(made.error());
  }
  if (options.now) {
    options.world.begin = GpsNow() - core::Seconds(static_cast<std::int64_t>(options.start_s));
  }
  auto optics = vision::MakeCamera(options.optics);
  if (!optics) return tl::unexpected(optics.error());
  options.world.lit = options.camera;
  const auto world = SiteWorld::Create(options.world);
  if (!world) return tl::unexpected(world.error());
  const SiteWorld& w = **world;
  const auto span = Span(w.recording(), options);
  if (!span) return tl::unexpected(span.error());
  if (auto written = WriteWorldTruth(w, options.instruments.run_dir); !written) {
    return tl::unexpected(written.error());
  }
  const MotionTrack track(w.recording());
  const std::vector<AhrsState> trace =
      MakeAhrsTrace(w.recording(), track, options.instruments.gps.seed + 1);
  std::unique_ptr<PictureSource> pictures;
  if (options.camera) {
    auto rendered = std::make_unique<RenderedPictures>(w, *optics, options.rendering);
    // Only where it must be: a picture is drawn for measure. In virtual time nothing may depend on
    // how quick this machine is.
    bool keeps_up = false;
    if (options.ahead_period_s > 0.0 && !options.virtual_time) {
      rendered->Prepare(span->first);
      const double takes_s = core::ToSeconds(rendered->PrepareTakes());
      keeps_up = takes_s < kLiveShare * options.ahead_period_s;
      std::printf("kawara-sim: a picture takes %.2f s: drawn %s the drive\n", takes_s,
                  keeps_up ? "during" : "before");
      std::fflush(stdout);
    }
    if (options.ahead_period_s > 0.0 && !keeps_up) {
      const auto drawn = rendered->RenderAhead(
          span->first, span->second, core::DurationFromSeconds(options.ahead_period_s),
          [](std::size_t done, std::size_t of) {
            if (done % 10 != 0 && done != of) return;
            std::printf("kawara-sim: drawn %zu of %zu pictures\n", done, of);
            std::fflush(stdout);
          },
          stop);
      if (!drawn) return tl::unexpected(drawn.error());
    }
    pictures = std::move(rendered);
  }
  const Eigen::Vector3d antenna_frd_m = w.robot().vehicle.antenna_frd_m;
  const MeasuredMotion motion{
      w.recording(),
      trace,
      span->first,
      span->second,
      [&w, antenna_frd_m](core::GpsTime t) { return w.trajectory().GeodeticAt(t, antenna_frd_m); },
      [&w](core::GpsTime t) { return w.trajectory().AttitudeAt(t).yaw_rad; },
      Scanners(w, options.world.seed),
      &w};
  if (options.virtual_time) {
    return RunVirtual(options.instruments, *options.virtual_time, motion, std::move(pictures),
                      stop);
  }
  return RunInstruments(options.instruments, motion, std::move(pictures), stop);
}

}  // namespace kawara::sim
