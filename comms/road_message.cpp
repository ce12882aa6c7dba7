#include "comms/road_message.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kawara::comms {
namespace {

constexpr double kMostMetres = 1e7;

void Append(road_stations_t& m, const core::RoadStation& s) {
  const auto place = [](const Eigen::Vector3d& p) {
    return std::vector<double>{p.x(), p.y(), p.z()};
  };
  m.along_m.push_back(static_cast<float>(s.along_m));
  m.left_enu_m.push_back(place(s.left_m));
  m.right_enu_m.push_back(place(s.right_m));
  m.road_width_m.push_back(static_cast<float>(s.road_width_m));
  m.passable_m.push_back(static_cast<float>(s.passable_m));
  m.passable_sd_m.push_back(static_cast<float>(s.passable_sd_m));
  m.gap_begin_m.push_back(static_cast<float>(s.gap_begin_m));
  m.gap_end_m.push_back(static_cast<float>(s.gap_end_m));
  m.unknown_share.push_back(static_cast<float>(s.unknown_share));
  m.passable_class.push_back(
      static_cast<std::int8_t>(std::min<std::uint32_t>(s.passable_class, 127)));
  m.observed_ns.push_back(s.observed.ns());
  ++m.n;
}

bool IsLength(double v) { return v >= 0.0 && v <= kMostMetres; }  // NaN: no

/// What is wrong with a station of a message; null: nothing.
const char* Fault(const core::RoadStation& s) {
  for (const Eigen::Vector3d& p : {s.left_m, s.right_m})
    if (!(p.array().abs() <= kMostMetres).all()) return "place not finite";
  for (const double v :
       {s.along_m, s.road_width_m, s.passable_m, s.passable_sd_m, s.gap_begin_m, s.gap_end_m})
    if (!IsLength(v)) return "a length that is none";
  if (!(s.unknown_share >= 0.0 && s.unknown_share <= 1.0)) return "share out of range";
  return nullptr;
}

core::RoadStation StationOf(const road_stations_t& m, std::size_t i) {
  const auto place = [](const std::vector<double>& p) { return Eigen::Vector3d(p[0], p[1], p[2]); };
  core::RoadStation s;
  s.road = m.road;
  s.along_m = static_cast<double>(m.along_m[i]);
  s.left_m = place(m.left_enu_m[i]);
  s.right_m = place(m.right_enu_m[i]);
  s.road_width_m = static_cast<double>(m.road_width_m[i]);
  s.passable_m = static_cast<double>(m.passable_m[i]);
  s.passable_sd_m = static_cast<double>(m.passable_sd_m[i]);
  s.gap_begin_m = static_cast<double>(m.gap_begin_m[i]);
  s.gap_end_m = static_cast<double>(m.gap_end_m[i]);
  s.unknown_share = static_cast<double>(m.unknown_share[i]);
  s.passable_class = static_cast<std::uint32_t>(std::max<std::int8_t>(0, m.passable_class[i]));
  s.observed = core::UtcTime::FromNs(m.observed_ns[i]);
  return s;
}

}  // namespace

core::Expected<std::vector<road_stations_t>> ToMessages(const RoadReport& report) {
  std::vector<road_stations_t> messages;
  for (const core::RoadStation& station : report.stations) {
    const auto begin = [&] {
      road_stations_t m{};
      m.robot = report.robot;
      m.mission = report.mission;
      m.origin_lat_deg = report.origin.lat_rad * core::kDegFromRad;
      m.origin_lon_deg = report.origin.lon_rad * core::kDegFromRad;
      m.origin_h_m = report.origin.h_ellipsoidal_m;
      m.road = station.road;
      Append(m, station);
      return m;
    };
    if (!messages.empty() && messages.back().road == station.road) {
      road_stations_t longer = messages.back();
      Append(longer, station);
      if (static_cast<std::size_t>(longer.getEncodedSize()) <= kMaxRoadBytes) {
        messages.back() = std::move(longer);
        continue;
      }
    }
    messages.push_back(begin());
    if (static_cast<std::size_t>(messages.back().getEncodedSize()) > kMaxRoadBytes)
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "road '" + station.road +
                            "': its name, the robot's and the mission's leave "
                            "no room in a message");
  }
  return messages;
}

core::Expected<RoadReport> FromMessage(const road_stations_t& m) {
  const auto bad = [](const std::string& what) {
    return core::Fail(core::ErrorCode::kFormat, "road_stations_t: " + what);
  };
  if (!(std::abs(m.origin_lat_deg) <= 90.0 && std::abs(m.origin_lon_deg) <= 360.0 &&
        std::abs(m.origin_h_m) <= 1e6))
    return bad("origin off the globe");
  RoadReport report;
  report.robot = m.robot;
  report.mission = m.mission;
  report.origin = {m.origin_lat_deg * core::kRadFromDeg, m.origin_lon_deg * core::kRadFromDeg,
                   m.origin_h_m};
  for (std::size_t i = 0; i < static_cast<std::size_t>(m.n); ++i) {
    report.stations.push_back(StationOf(m, i));
    if (const char* fault = Fault(report.stations.back())) return bad(fault);
  }
  return report;
}

}  // namespace kawara::comms
