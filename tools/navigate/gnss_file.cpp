// gnss.csv: the file with the most columns, and the most that may be missing.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "estimation/navigation_config.hpp"
#include "tools/navigate/sensor_files.hpp"

namespace kawara::navigate {
namespace {

using Kind = CsvColumn::Kind;
constexpr Kind kIfThere = Kind::kOptionalNumber;

enum Column : std::size_t {
  kT,
  kLat,
  kLon,
  kHeight,
  kQuality,
  kSdN,
  kSdE,
  kSdD,
  kSatellites,
  kVn,
  kVe,
  kVd,
  kSdVn,
  kSdVe,
  kSdVd,
  kHeading,
  kSdHeading,
  kReceived,
};
constexpr std::array<CsvColumn, 18> kColumns{{{"t", Kind::kTime},
                                              {"lat", kIfThere},
                                              {"lon", kIfThere},
                                              {"h", kIfThere},
                                              {"q"},
                                              {"sdN", kIfThere},
                                              {"sdE", kIfThere},
                                              {"sdD", kIfThere},
                                              {"nsat", kIfThere},
                                              {"vN", kIfThere},
                                              {"vE", kIfThere},
                                              {"vD", kIfThere},
                                              {"sdvN", kIfThere},
                                              {"sdvE", kIfThere},
                                              {"sdvD", kIfThere},
                                              {"heading", kIfThere},
                                              {"sd_heading", kIfThere},
                                              {"t_rx", Kind::kOptionalTime}}};

/// The codes of RTKLIB's solution files.
core::RtkState StateOf(double quality) {
  switch (static_cast<int>(quality)) {
    case 1:
      return core::RtkState::kFixed;
    case 2:
      return core::RtkState::kFloat;
    case 3:
    case 4:
    case 6:
      return core::RtkState::kCodeDifferential;
    case 5:
      return core::RtkState::kAutonomous;
    default:
      return core::RtkState::kNone;
  }
}

/// What is believed where the file states no deviations; the order of magnitude that receivers'
/// data sheets give for each state.
struct Sigma {
  double horizontal_m;
  double vertical_m;
  double velocity_mps;
};
Sigma SigmaOf(core::RtkState state) {
  switch (state) {
    case core::RtkState::kFixed:
      return {0.02, 0.04, 0.1};
    case core::RtkState::kFloat:
      return {0.4, 0.8, 0.1};
    case core::RtkState::kCodeDifferential:
      return {1.0, 2.0, 0.2};
    default:
      return {3.0, 6.0, 0.3};
  }
}

double PositiveOr(double stated, double otherwise) { return stated > 0.0 ? stated : otherwise; }

void TakeVelocity(std::span<const double> n, core::GnssFix& fix) {
  const Eigen::Vector3d ned(n[kVn], n[kVe], n[kVd]);
  if (!ned.allFinite()) return;
  const double sigma = SigmaOf(fix.rtk).velocity_mps;
  fix.has_velocity = true;
  fix.velocity_enu_mps << ned.y(), ned.x(), -ned.z();
  fix.velocity_sd_enu_mps << PositiveOr(n[kSdVe], sigma), PositiveOr(n[kSdVn], sigma),
      PositiveOr(n[kSdVd], sigma);
}

void TakePosition(std::span<const double> n, core::GnssFix& fix) {
  const Sigma sigma = SigmaOf(fix.rtk);
  fix.has_position = true;
  fix.antenna = {n[kLat] * core::kRadFromDeg, core::WrapPi(n[kLon] * core::kRadFromDeg),
                 n[kHeight]};
  const Eigen::Vector3d sd_enu(PositiveOr(n[kSdE], sigma.horizontal_m),
                               PositiveOr(n[kSdN], sigma.horizontal_m),
                               PositiveOr(n[kSdD], sigma.vertical_m));
  fix.position_cov_enu_m2 = sd_enu.cwiseAbs2().asDiagonal();
  fix.covariance_from_receiver = n[kSdN] > 0.0 && n[kSdE] > 0.0 && n[kSdD] > 0.0;
}

/// Empty, or what is wrong with the row.
std::string Take(const CsvReader::Row& row, bool needs_arrival, GnssRow& out) {
  const auto& n = row.number;
  const double q = n[kQuality];
  if (q != std::floor(q) || q < 0.0 || q > 6.0) return "q must be a whole number 0..6";
  out.fix.time = *row.time[kT];
  if (needs_arrival && !row.time[kReceived]) return "t_rx is missing";
  out.received = row.time[kReceived].value_or(out.fix.time);
  out.fix.rtk = StateOf(q);
  out.fix.native_quality = static_cast<std::uint8_t>(q);
  out.fix.geoid_separation_m = out.fix.hdop = out.fix.correction_age_s = out.fix.latency_s =
      std::numeric_limits<double>::quiet_NaN();
  if (n[kSatellites] >= 0.0 && n[kSatellites] < 1000.0) {
    out.fix.satellites = static_cast<std::uint16_t>(n[kSatellites]);
  }
  if (out.fix.rtk != core::RtkState::kNone) {
    if (!(std::abs(n[kLat]) <= 90.0)) return "lat must be -90..90";
    if (!(std::abs(n[kLon]) <= 360.0)) return "lon must be -180..180";
    if (!(std::abs(n[kHeight]) <= 1e5)) return "h must be within 100 km of the ellipsoid";
    TakePosition(n, out.fix);
    TakeVelocity(n, out.fix);
  }
  if (!std::isnan(n[kHeading])) {
    if (std::abs(n[kHeading]) > 360.0) return "heading must be 0..360";
    estimation::AttitudeSample heading;
    heading.time = out.fix.time;
    heading.has_heading = true;
    heading.attitude.yaw_rad = core::WrapPi(n[kHeading] * core::kRadFromDeg);
    heading.heading_sd_rad = n[kSdHeading] > 0.0
                                 ? n[kSdHeading] * core::kRadFromDeg
                                 : estimation::NavigationConfig().two_antenna_sd_rad;
    out.heading = heading;
  }
  return {};
}

}  // namespace

core::Expected<GnssFile> ReadGnss(const std::string& path, bool needs_arrival) {
  auto reader = CsvReader::Open(path, kColumns);
  if (!reader) return tl::unexpected(reader.error());
  const auto missing = [&](Column column, const std::string& why) {
    return core::Fail(core::ErrorCode::kFormat,
                      path + ":1: no column '" + std::string(kColumns[column].name) + "'" + why);
  };
  for (const Column column : {kLat, kLon, kHeight}) {
    if (!reader->Has(column)) return missing(column, "");
  }
  if (needs_arrival && !reader->Has(kReceived)) {
    return missing(kReceived, ", which --use-arrival-times needs");
  }
  GnssFile file;
  for (;;) {
    const auto row = reader->Next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) break;
    GnssRow epoch;
    if (const std::string wrong = Take(**row, needs_arrival, epoch); !wrong.empty()) {
      reader->Reject(wrong);
    } else {
      file.rows.push_back(std::move(epoch));
    }
  }
  file.report = reader->report();
  return file;
}

}  // namespace kawara::navigate
