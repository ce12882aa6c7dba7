#include "sim/motion/recording.hpp"

#include <algorithm>
#include <cmath>

#include "sim/motion/number_table.hpp"

namespace kawara::sim {
namespace {

constexpr double kWeekSeconds = 604800.0;

core::GpsTime TimeInWeek(int week, double seconds_of_week) {
  // The recordings print at most 0.1 ms: rounding to a microsecond gives back exactly what was
  // printed.
  const auto us = static_cast<std::int64_t>(std::llround(seconds_of_week * 1e6));
  return core::FromWeek({.week = week, .time_of_week = core::Nanoseconds(us * 1000)});
}

/// Time of week in range and increasing: what both streams must satisfy.
tl::unexpected<core::Error> BadTime(const NumberTable& table, std::size_t row) {
  return tl::unexpected(table.RowError(
      row, "t", "must be GPS seconds of week, 0..604800, later than in the line before"));
}
bool TimeIsGood(const NumberTable& table, std::size_t row) {
  const double t = table.rows[row][0];
  return t >= 0.0 && t < kWeekSeconds && (row == 0 || t > table.rows[row - 1][0]);
}

core::Expected<RecordingSite> LoadSite(const std::filesystem::path& folder) {
  const auto table = ReadNumberTable(
      folder / "site.csv",
      {"gps_week", "imu_late_s", "geoid_m", "declination_deg", "dip_deg", "field_gauss"});
  if (!table) return tl::unexpected(table.error());
  if (table->rows.size() != 1) {
    return core::Fail(core::ErrorCode::kFormat, table->file + ": expected exactly one row");
  }
  const std::vector<double>& row = table->rows[0];
  if (!(row[0] >= 0.0 && row[0] < 10000.0 && row[0] == std::floor(row[0]))) {
    return tl::unexpected(table->RowError(0, "gps_week", "must be a whole number 0..9999"));
  }
  if (!(std::abs(row[1]) < 1.0))
    return tl::unexpected(table->RowError(0, "imu_late_s", "must be within 1 s"));
  if (!(std::abs(row[2]) < 200.0))
    return tl::unexpected(table->RowError(0, "geoid_m", "must be within 200 m"));
  if (!(row[5] > 0.1 && row[5] < 1.0)) {
    return tl::unexpected(table->RowError(0, "field_gauss", "must be 0.1..1.0"));
  }
  RecordingSite site;
  site.gps_week = static_cast<int>(row[0]);
  site.imu_late_s = row[1];
  site.geoid_m = row[2];
  site.declination_rad = row[3] * core::kRadFromDeg;
  site.dip_rad = row[4] * core::kRadFromDeg;
  site.field_gauss = row[5];
  return site;
}

core::Expected<std::vector<RecordedFix>> LoadFixes(const std::filesystem::path& folder, int week) {
  const auto table =
      ReadNumberTable(folder / "gnss.csv", {"t", "lat", "lon", "h", "sdN", "sdE", "sdD", "q",
                                            "nsat", "vN", "vE", "vD", "sdvN", "sdvE", "sdvD"});
  if (!table) return tl::unexpected(table.error());
  std::vector<RecordedFix> fixes;
  fixes.reserve(table->rows.size());
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    const std::vector<double>& row = table->rows[i];
    if (!TimeIsGood(*table, i)) return BadTime(*table, i);
    if (!(std::abs(row[1]) <= 90.0))
      return tl::unexpected(table->RowError(i, "lat", "must be -90..90"));
    if (!(std::abs(row[2]) <= 180.0))
      return tl::unexpected(table->RowError(i, "lon", "must be -180..180"));
    if (row[7] != 1.0 && row[7] != 2.0) {
      return tl::unexpected(table->RowError(i, "q", "must be 1 (fixed) or 2 (float)"));
    }
    if (!(row[8] >= 0.0 && row[8] < 100.0))
      return tl::unexpected(table->RowError(i, "nsat", "must be 0..99"));
    RecordedFix& fix = fixes.emplace_back();
    fix.time = TimeInWeek(week, row[0]);
    fix.antenna = {row[1] * core::kRadFromDeg, row[2] * core::kRadFromDeg, row[3]};
    fix.sd_ned_m = {row[4], row[5], row[6]};
    fix.rtk = row[7] == 1.0 ? core::RtkState::kFixed : core::RtkState::kFloat;
    fix.satellites = static_cast<int>(row[8]);
    fix.velocity_ned_mps = {row[9], row[10], row[11]};
    fix.velocity_sd_ned_mps = {row[12], row[13], row[14]};
  }
  return fixes;
}

core::Expected<std::vector<RecordedImu>> LoadImu(const std::filesystem::path& folder, int week) {
  const auto table = ReadNumberTable(folder / "imu.csv", {"t", "wx", "wy", "wz", "ax", "ay", "az"});
  if (!table) return tl::unexpected(table.error());
  std::vector<RecordedImu> samples;
  samples.reserve(table->rows.size());
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    const std::vector<double>& row = table->rows[i];
    if (!TimeIsGood(*table, i)) return BadTime(*table, i);
    RecordedImu& sample = samples.emplace_back();
    sample.time = TimeInWeek(week, row[0]);
    sample.rate_radps = {row[1], row[2], row[3]};
    sample.specific_force_mps2 = {row[4], row[5], row[6]};
  }
  return samples;
}

}  // namespace

core::Expected<Recording> LoadRecording(const std::filesystem::path& folder) {
  const auto site = LoadSite(folder);
  if (!site) return tl::unexpected(site.error());
  auto fixes = LoadFixes(folder, site->gps_week);
  if (!fixes) return tl::unexpected(fixes.error());
  auto imu = LoadImu(folder, site->gps_week);
  if (!imu) return tl::unexpected(imu.error());
  Recording recording{*site, std::move(*fixes), std::move(*imu)};
  if (recording.fixes.size() < 2 || recording.imu.size() < 2 ||
      recording.end() <= recording.begin()) {
    return core::Fail(
        core::ErrorCode::kFormat,
        folder.string() + ": gnss.csv and imu.csv must have two rows or more and overlap in time");
  }
  return recording;
}

}  // namespace kawara::sim
