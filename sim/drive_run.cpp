#include "sim/drive_run.hpp"

#include <algorithm>
#include <ctime>
#include <system_error>

#include "sim/camera/doughnut_pictures.hpp"
#include "sim/camera/folder_pictures.hpp"

namespace kawara::sim {
namespace {

core::UtcTime UtcNow() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return core::UtcTime::FromNs(std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec);
}

core::Expected<std::unique_ptr<PictureSource>> OpenPictures(const DriveOptions& options,
                                                            const MotionTrack& track) {
  std::error_code ignored;
  if (std::filesystem::is_directory(options.panorama, ignored)) {
    auto pictures = FolderPictures::Open(options.panorama);
    if (!pictures) return tl::unexpected(pictures.error());
    return std::make_unique<FolderPictures>(std::move(*pictures));
  }
  auto pictures = DoughnutPictures::Open(options.panorama, options.doughnut, options.jpeg_quality);
  if (!pictures) return tl::unexpected(pictures.error());
  return std::make_unique<TurningPictures>(std::move(*pictures), track);
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

}  // namespace

core::Expected<InstrumentSummary> RunDrive(const DriveOptions& options,
                                           const std::atomic<bool>& stop) {
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
  const std::vector<AhrsState> trace =
      MakeAhrsTrace(recording, track, options.instruments.gps.seed + 1);
  std::unique_ptr<PictureSource> pictures;
  if (!options.panorama.empty()) {
    auto opened = OpenPictures(options, track);
    if (!opened) return tl::unexpected(opened.error());
    pictures = std::move(*opened);
  }

  const MeasuredMotion motion{recording,
                              trace,
                              span->begin,
                              span->end,
                              [&](core::GpsTime t) { return track.PositionAt(t); },
                              [&](core::GpsTime t) { return track.YawAt(t); }};
  if (options.virtual_time) {
    return RunVirtual(options.instruments, *options.virtual_time, motion, std::move(pictures),
                      stop);
  }
  return RunInstruments(options.instruments, motion, std::move(pictures), stop);
}

}  // namespace kawara::sim
