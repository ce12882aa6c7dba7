#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/measurements.hpp"
#include "estimation/nav_types.hpp"
#include "tools/navigate/csv_reader.hpp"

/// The sensors' CSV files as measurements. Angles in files are degrees, axes forward-right-down.
/// Errors: those of CsvReader, always with file and line.
namespace kawara::navigate {

/// imu.csv: t, wx, wy, wz [rad/s], ax, ay, az [m/s^2, specific force]. Read as it is used, because
/// it is the long one.
class ImuFile {
 public:
  static core::Expected<ImuFile> Open(const std::string& path);
  /// Nothing at the end.
  core::Expected<std::optional<estimation::ImuSample>> Next();
  const CsvReport& report() const { return reader_.report(); }
  double progress() const { return reader_.progress(); }

 private:
  explicit ImuFile(CsvReader reader) : reader_(std::move(reader)) {}
  CsvReader reader_;
};

/// An epoch of the receiver.
struct GnssRow {
  core::GnssFix fix;
  std::optional<estimation::AttitudeSample> heading;  ///< of a second antenna
  core::GpsTime received;                             ///< t_rx; the epoch where it is not known
};

struct GnssFile {
  std::vector<GnssRow> rows;  ///< as in the file
  CsvReport report;
};

/// gnss.csv: t, lat, lon [deg], h [m, ellipsoidal], q (1 fixed, 2 float, 3 SBAS, 4 DGPS, 5 single,
/// 6 PPP, 0 none), and if they are there sdN, sdE, sdD [m] (otherwise a table by q), nsat, vN, vE,
/// vD [m/s], sdvN, sdvE, sdvD, heading, sd_heading [deg] (second antenna), t_rx (arrival).
/// `needs_arrival`: without t_rx it is an error.
core::Expected<GnssFile> ReadGnss(const std::string& path, bool needs_arrival);

template <class Sample>
struct SampleFile {
  std::vector<Sample> rows;
  CsvReport report;
};

/// odo.csv: t, vx [m/s], and if it is there wz [rad/s].
core::Expected<SampleFile<estimation::OdometrySample>> ReadOdometry(const std::string& path);
/// ahrs.csv: t, roll, pitch, and if it is there yaw [deg].
core::Expected<SampleFile<estimation::AttitudeSample>> ReadAttitude(const std::string& path);

/// A stretch of time, its end not included.
struct TimeWindow {
  core::GpsTime begin;
  core::GpsTime end;
  bool Contains(core::GpsTime t) const { return t >= begin && t < end; }
};

/// blanks.csv: t_start, t_end; of a file with a column `run` those rows where it is `run`. A header
/// is not needed. Errors also: such a file and no `run`, or no window of that run.
core::Expected<SampleFile<TimeWindow>> ReadWindows(const std::string& path, std::optional<int> run);

/// holdout.csv: t, ascending afterwards. A header is not needed.
core::Expected<SampleFile<core::GpsTime>> ReadEpochs(const std::string& path);

}  // namespace kawara::navigate
