#pragma once
#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"

namespace kawara::sim {

/// What really was, beside what the instruments said: two CSV files for tests and for judging
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
  static core::Expected<TruthLog> Create(const std::filesystem::path& folder);
  void Epoch(core::GpsTime gps, core::MonoTime mono, const core::Geodetic& antenna, int quality);
  void Exposure(std::uint32_t trigger_sequence, std::uint32_t frame_sequence, core::GpsTime gps,
                core::MonoTime mono, const core::Geodetic& antenna, double yaw_rad);

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  TruthLog(File epochs, File exposures)
      : epochs_(std::move(epochs)), exposures_(std::move(exposures)) {}
  File epochs_;
  File exposures_;
};

}  // namespace kawara::sim
