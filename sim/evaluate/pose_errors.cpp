#include "sim/evaluate/pose_errors.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/evaluate/table.hpp"

namespace kawara::sim {
namespace {

std::vector<std::string> Spelt(const std::vector<std::string>& names) {
  std::vector<std::string> all;
  for (const std::string& name : names) {
    all.push_back(name);
    all.push_back("pose." + name);
  }
  return all;
}

/// The column's name, or empty.
std::string Optional(const Table& table, const std::vector<std::string>& names) {
  return table.ColumnOf(Spelt(names)).value_or("");
}

double NumberOr(const Table& table, std::size_t row, const std::string& column, double otherwise) {
  return column.empty() ? otherwise : table.Number(row, column);
}

/// Standard deviations east, north, up, from whichever columns there are.
struct SdColumns {
  std::array<std::string, 3> names;
  bool squared = false;
  static SdColumns Of(const Table& table) {
    SdColumns columns;
    columns.names = {Optional(table, {"sd_east_m"}), Optional(table, {"sd_north_m"}),
                     Optional(table, {"sd_up_m"})};
    if (!columns.names[0].empty()) return columns;
    columns.squared = true;
    for (std::size_t i = 0; i < 3; ++i) {
      columns.names[i] = Optional(table, {"position_cov_enu_m2[" + std::to_string(4 * i) + "]"});
    }
    return columns;
  }
  Eigen::Vector3d At(const Table& table, std::size_t row) const {
    Eigen::Vector3d sd;
    for (std::size_t i = 0; i < 3; ++i) {
      const double value = NumberOr(table, row, names[i], std::nan(""));
      sd[static_cast<Eigen::Index>(i)] = squared ? std::sqrt(value) : value;
    }
    return sd;
  }
};

/// Between two attitudes by the share; the shorter way round for each angle (rows are close).
core::Attitude Between(const core::Attitude& a, const core::Attitude& b, double share) {
  const auto mix = [share](double from, double to) {
    return core::WrapPi(from + share * core::WrapPi(to - from));
  };
  return {mix(a.roll_rad, b.roll_rad), mix(a.pitch_rad, b.pitch_rad), mix(a.yaw_rad, b.yaw_rad)};
}

std::optional<TablePose> At(const std::vector<TablePose>& truth, core::GpsTime time,
                            double max_gap_s) {
  const auto after =
      std::lower_bound(truth.begin(), truth.end(), time,
                       [](const TablePose& pose, core::GpsTime t) { return pose.time < t; });
  if (after == truth.end()) return std::nullopt;
  if (after->time == time) return *after;
  if (after == truth.begin()) return std::nullopt;
  const TablePose& a = *(after - 1);
  const TablePose& b = *after;
  const double gap_s = core::ToSeconds(b.time - a.time);
  if (gap_s > max_gap_s) return std::nullopt;
  const double share = core::ToSeconds(time - a.time) / gap_s;
  TablePose pose;
  pose.time = time;
  pose.position = core::OffsetNed(a.position, share * core::NedBetween(a.position, b.position));
  if (a.attitude && b.attitude) pose.attitude = Between(*a.attitude, *b.attitude, share);
  return pose;
}

}  // namespace

core::Expected<std::vector<TablePose>> ReadPoses(const std::string& path) {
  const auto table = Table::Read(path, {"obs_pose", "poses", "trajectory_points"});
  if (!table) return tl::unexpected(table.error());
  const auto time = table->ColumnOf(Spelt({"gps_ns"}));
  if (!time) return tl::unexpected(time.error());
  const auto lat = table->ColumnOf(Spelt({"lat_deg"}));
  if (!lat) return tl::unexpected(lat.error());
  const auto lon = table->ColumnOf(Spelt({"lon_deg"}));
  if (!lon) return tl::unexpected(lon.error());
  const auto height = table->ColumnOf(Spelt({"h_ellipsoidal_m", "h_m"}));
  if (!height) return tl::unexpected(height.error());
  const std::string roll = Optional(*table, {"roll_deg"});
  const std::string pitch = Optional(*table, {"pitch_deg"});
  const std::string yaw = Optional(*table, {"yaw_deg"});
  const std::string state = Optional(*table, {"rtk_state", "q"});
  const SdColumns sd = SdColumns::Of(*table);

  std::vector<TablePose> poses;
  for (std::size_t row = 0; row < table->size(); ++row) {
    TablePose pose;
    pose.time = core::GpsTime::FromNs(table->Integer(row, *time));
    pose.position = {table->Number(row, *lat) * core::kRadFromDeg,
                     table->Number(row, *lon) * core::kRadFromDeg, table->Number(row, *height)};
    if (!pose.time.IsSet() || !std::isfinite(pose.position.lat_rad) ||
        !std::isfinite(pose.position.lon_rad) || !std::isfinite(pose.position.h_ellipsoidal_m)) {
      continue;
    }
    const core::Attitude attitude{NumberOr(*table, row, roll, 0.0) * core::kRadFromDeg,
                                  NumberOr(*table, row, pitch, 0.0) * core::kRadFromDeg,
                                  NumberOr(*table, row, yaw, std::nan("")) * core::kRadFromDeg};
    if (std::isfinite(attitude.roll_rad + attitude.pitch_rad + attitude.yaw_rad)) {
      pose.attitude = attitude;
    }
    pose.sd_enu_m = sd.At(*table, row);
    if (!state.empty()) pose.state = table->Text(row, state);
    poses.push_back(std::move(pose));
  }
  if (poses.empty()) return core::Fail(core::ErrorCode::kFormat, path + ": no pose in it");
  std::stable_sort(poses.begin(), poses.end(),
                   [](const TablePose& a, const TablePose& b) { return a.time < b.time; });
  return poses;
}

core::Expected<ErrorReport> ComparePoses(const std::vector<TablePose>& truth,
                                         const std::vector<TablePose>& result, double max_gap_s) {
  std::vector<double> east, north, up, horizontal, all, roll, pitch, yaw, normalised;
  std::map<std::string, std::vector<double>> by_state;
  std::size_t uncovered = 0;
  for (const TablePose& pose : result) {
    const auto right = At(truth, pose.time, max_gap_s);
    if (!right) {
      ++uncovered;
      continue;
    }
    const Eigen::Vector3d ned = core::NedBetween(right->position, pose.position);
    north.push_back(ned.x());
    east.push_back(ned.y());
    up.push_back(-ned.z());
    horizontal.push_back(ned.head<2>().norm());
    all.push_back(ned.norm());
    by_state[pose.state].push_back(ned.head<2>().norm());
    const double in_sd = ned.y() * ned.y() / (pose.sd_enu_m.x() * pose.sd_enu_m.x()) +
                         ned.x() * ned.x() / (pose.sd_enu_m.y() * pose.sd_enu_m.y());
    if (std::isfinite(in_sd)) normalised.push_back(in_sd / 2.0);
    if (!right->attitude || !pose.attitude) continue;
    const auto angle_deg = [](double from, double to) {
      return core::WrapPi(to - from) * core::kDegFromRad;
    };
    roll.push_back(angle_deg(right->attitude->roll_rad, pose.attitude->roll_rad));
    pitch.push_back(angle_deg(right->attitude->pitch_rad, pose.attitude->pitch_rad));
    yaw.push_back(angle_deg(right->attitude->yaw_rad, pose.attitude->yaw_rad));
  }
  if (all.empty()) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "no pose of the result lies within the truth's time: the wrong drive?");
  }
  ErrorReport report;
  report.Add("east", "m", Summarise(east));
  report.Add("north", "m", Summarise(north));
  report.Add("up", "m", Summarise(up));
  report.Add("horizontal", "m", Summarise(horizontal));
  report.Add("3D", "m", Summarise(all));
  if (by_state.size() > 1) {
    for (const auto& [state, errors] : by_state) {
      report.Add("horizontal while " + state, "m", Summarise(errors));
    }
  }
  if (!yaw.empty()) {
    report.Add("roll", "deg", Summarise(roll));
    report.Add("pitch", "deg", Summarise(pitch));
    report.Add("yaw", "deg", Summarise(yaw));
  }
  if (!normalised.empty()) {
    report.Add("squared horizontal error / claimed variance", "1", Summarise(normalised));
  }
  report.Add("poses outside the truth", "poses", static_cast<double>(uncovered));
  return report;
}

}  // namespace kawara::sim
