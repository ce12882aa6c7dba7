#pragma once
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/run/truth_recorder.hpp"

namespace kawara::sim {

/// What really was, beside what the instruments said: two CSV files, and truth.lcm if the drive is
/// through a simulated site (see TruthRecorder), for tests and for judging
/// estimates. One thread; lines go out at once, so that a killed run leaves whole lines.
///   truth_epochs.csv     gps_ns,mono_ns,lat_deg,lon_deg,h_m,q   every recorded fix of the run;
///   mono_ns is the
///                        instant of validity on this machine's clock; q 1 fixed, 2 float, as
///                        recorded
///   truth_exposures.csv trigger_sequence,frame_sequence,gps_ns,mono_ns,lat_deg,lon_deg,h_m,yaw_deg
///                        every exposure made; position of the antenna, yaw as the picture was
///                        rendered (true heading, 0..360)
class TruthLog {
 public:
  /// `world`: null for a recorded drive; else must outlive it. `begin`: of the part that is played.
  static core::Expected<TruthLog> Create(const std::filesystem::path& folder,
                                         const SiteWorld* world, core::GpsTime begin);
  void Epoch(core::GpsTime gps, core::MonoTime mono, const core::Geodetic& antenna, int quality);
  void Exposure(std::uint32_t trigger_sequence, std::uint32_t frame_sequence, core::GpsTime gps,
                core::MonoTime mono, const core::Geodetic& antenna, double yaw_rad);
  /// The poses until a little before `now`: an exposure that is told of late still finds its place.
  void Advance(core::GpsTime now);
  /// The rest of truth.lcm. Error: any that it had.
  core::Expected<void> Close(core::GpsTime end);

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  TruthLog(File epochs, File exposures, std::optional<TruthRecorder> recorder)
      : epochs_(std::move(epochs)),
        exposures_(std::move(exposures)),
        recorder_(std::move(recorder)) {}
  void Note(core::Expected<void> done);
  File epochs_;
  File exposures_;
  std::optional<TruthRecorder> recorder_;
  core::Expected<void> recorded_;  ///< the first error
};

}  // namespace kawara::sim
