#include <algorithm>
#include <cstdio>
#include <optional>

#include "tools/camera/camera_commands.hpp"
#include "tools/camera/camera_frames.hpp"

namespace kawara::tools {
namespace {

double Milliseconds(core::Duration d) { return 1e3 * core::ToSeconds(d); }

/// What is remembered of the frames for the summary.
struct Summary {
  std::vector<double> intervals_ms;
  std::vector<double> delays_ms;  ///< start of exposure to the whole frame being here
  core::MonoTime first, last;
  std::optional<std::uint32_t> sequence;
  int frames = 0;

  void Add(const drivers::Frame& frame, bool quiet) {
    const double delay_ms = Milliseconds(frame.arrival - frame.exposure_start);
    delays_ms.push_back(delay_ms);
    double interval_ms = 0.0;
    if (frames++ == 0) {
      first = frame.exposure_start;
    } else {
      interval_ms = Milliseconds(frame.exposure_start - last);
      intervals_ms.push_back(interval_ms);
    }
    if (!quiet) {
      std::printf("frame %10u  exposure %.6f s  +%8.3f ms  here after %7.3f ms  %8zu bytes",
                  frame.sequence, core::ToSeconds(frame.exposure_start - core::MonoTime{}),
                  interval_ms, delay_ms, frame.bytes.size());
      const std::uint32_t lost = sequence ? frame.sequence - *sequence - 1 : 0;
      if (lost > 0 && lost < (1U << 31)) std::printf("  %u lost before it", lost);
      std::printf("\n");
    }
    sequence = frame.sequence;
    last = frame.exposure_start;
  }
};

void PrintSpread(const char* what, std::vector<double>& values_ms) {
  if (values_ms.empty()) return;
  std::sort(values_ms.begin(), values_ms.end());
  std::printf("%s: least %.3f, median %.3f, 95 %% %.3f, most %.3f ms\n", what, values_ms.front(),
              values_ms[values_ms.size() / 2], values_ms[values_ms.size() * 95 / 100],
              values_ms.back());
}

}  // namespace

core::Expected<int> CameraStream(const CameraOptions& options, int count, bool quiet) {
  auto config = ConfigOf(options);
  if (!config) return tl::unexpected(config.error());
  core::Counters counters;
  drivers::V4l2Camera camera(std::move(*config), counters);
  Summary summary;
  const auto taken = ForFrames(camera, core::DurationFromSeconds(options.patience_s),
                               [&](const drivers::Frame& frame) {
                                 if (summary.frames == 0)
                                   std::printf("%s\n", camera.Description().c_str());
                                 summary.Add(frame, quiet);
                                 return summary.frames < count;
                               });
  if (!taken && summary.frames == 0) return tl::unexpected(taken.error());
  const double span_s = core::ToSeconds(summary.last - summary.first);
  std::printf("%d frames", summary.frames);
  if (span_s > 0.0) std::printf(", %.3f Hz", (summary.frames - 1) / span_s);
  std::printf("\n");
  PrintSpread("between exposures", summary.intervals_ms);
  PrintSpread("exposure to arrival", summary.delays_ms);
  for (const core::Counters::Value& counter : counters.Snapshot()) {
    if (counter.value != 0) {
      std::printf("%s %lld\n", counter.name.c_str(), static_cast<long long>(counter.value));
    }
  }
  if (taken) return 0;
  std::fprintf(stderr, "kawara-camera: %s\n", taken.error().message.c_str());
  return 1;
}

}  // namespace kawara::tools
