#include "sim/run/truth_log.hpp"

#include <cerrno>

namespace kawara::sim {
namespace {

/// A picture that is drawn live may take so long before its exposure is told.
constexpr core::Duration kLatestExposure = core::Seconds(2);

std::FILE* OpenWithHeader(const std::filesystem::path& file, const char* header) {
  std::FILE* const out = std::fopen(file.c_str(), "we");
  if (out == nullptr) return nullptr;
  std::setvbuf(out, nullptr, _IOLBF, 4096);
  std::fprintf(out, "%s\n", header);
  return out;
}

}  // namespace

core::Expected<TruthLog> TruthLog::Create(const std::filesystem::path& folder,
                                          const SiteWorld* world, core::GpsTime begin) {
  const std::filesystem::path epochs_file = folder / "truth_epochs.csv";
  File epochs(OpenWithHeader(epochs_file, "gps_ns,mono_ns,lat_deg,lon_deg,h_m,q"), std::fclose);
  if (!epochs) return tl::unexpected(core::ErrnoError("create " + epochs_file.string(), errno));
  const std::filesystem::path exposures_file = folder / "truth_exposures.csv";
  File exposures(
      OpenWithHeader(exposures_file,
                     "trigger_sequence,frame_sequence,gps_ns,mono_ns,lat_deg,lon_deg,h_m,yaw_deg"),
      std::fclose);
  if (!exposures)
    return tl::unexpected(core::ErrnoError("create " + exposures_file.string(), errno));
  std::optional<TruthRecorder> recorder;
  if (world != nullptr) {
    auto created = TruthRecorder::Create(folder / "truth.lcm", *world, begin);
    if (!created) return tl::unexpected(created.error());
    recorder.emplace(std::move(*created));
  }
  return TruthLog(std::move(epochs), std::move(exposures), std::move(recorder));
}

void TruthLog::Note(core::Expected<void> done) {
  if (recorded_) recorded_ = std::move(done);
}

void TruthLog::Advance(core::GpsTime now) {
  if (recorder_ && recorded_) Note(recorder_->AdvanceTo(now - kLatestExposure));
}

core::Expected<void> TruthLog::Close(core::GpsTime end) {
  if (recorder_ && recorded_) Note(recorder_->AdvanceTo(end));
  if (recorder_ && recorded_) Note(recorder_->Close());
  return recorded_;
}

void TruthLog::Epoch(core::GpsTime gps, core::MonoTime mono, const core::Geodetic& antenna,
                     int quality) {
  std::fprintf(epochs_.get(), "%lld,%lld,%.10f,%.10f,%.4f,%d\n", static_cast<long long>(gps.ns()),
               static_cast<long long>(mono.ns()), antenna.lat_rad * core::kDegFromRad,
               antenna.lon_rad * core::kDegFromRad, antenna.h_ellipsoidal_m, quality);
}

void TruthLog::Exposure(std::uint32_t trigger_sequence, std::uint32_t frame_sequence,
                        core::GpsTime gps, core::MonoTime mono, const core::Geodetic& antenna,
                        double yaw_rad) {
  const double yaw_deg = yaw_rad * core::kDegFromRad;
  std::fprintf(exposures_.get(), "%u,%u,%lld,%lld,%.10f,%.10f,%.4f,%.4f\n", trigger_sequence,
               frame_sequence, static_cast<long long>(gps.ns()), static_cast<long long>(mono.ns()),
               antenna.lat_rad * core::kDegFromRad, antenna.lon_rad * core::kDegFromRad,
               antenna.h_ellipsoidal_m, yaw_deg < 0.0 ? yaw_deg + 360.0 : yaw_deg);
  if (recorder_ && recorded_)
    Note(recorder_->Exposure(trigger_sequence, frame_sequence, gps, mono));
}

}  // namespace kawara::sim
