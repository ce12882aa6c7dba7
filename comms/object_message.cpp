#include "comms/object_message.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kawara::comms {
namespace {

constexpr int kParameters = core::ChangedObject::kParameters;

tl::unexpected<core::Error> Bad(const std::string& what) {
  return core::Fail(core::ErrorCode::kFormat, "changed_object_t: " + what);
}

template <std::size_t kN>
bool AllFinite(const double (&values)[kN]) {
  return std::all_of(std::begin(values), std::end(values),
                     [](double v) { return std::isfinite(v); });
}

/// What is wrong with a message; null: nothing.
const char* Fault(const changed_object_t& m) {
  const bool on_the_globe = std::abs(m.origin_lat_deg) <= 90.0 &&
                            std::abs(m.origin_lon_deg) <= 360.0 && std::abs(m.origin_h_m) <= 1e6;
  if (!on_the_globe) return "origin off the globe";
  if (m.uid.empty()) return "no uid";
  if (m.revision < 1) return "revision below 1";
  if (m.state < 0 || m.state > static_cast<std::int8_t>(core::ChangeState::kGone))
    return "unknown state";
  if (m.size_class < 0 || m.size_class > static_cast<std::int8_t>(core::SizeClass::kPerson))
    return "unknown class";
  if (m.sides_seen < 0 || m.sides_seen >= 1 << core::kBoxSides) return "unknown sides";
  if (!AllFinite(m.centre_enu_m) || !AllFinite(m.size_m) || !std::isfinite(m.heading_deg) ||
      std::isinf(m.second_heading_deg))
    return "box not finite";
  if (!AllFinite(m.covariance)) return "covariance not finite";
  if (!std::isfinite(m.existence_probability) || !std::isfinite(m.class_probability))
    return "probability not finite";
  if (m.voxels < 0 || m.voxels > std::numeric_limits<std::uint32_t>::max() || m.votes < 0)
    return "count out of range";
  return nullptr;
}

}  // namespace

core::Expected<changed_object_t> ToMessage(const ObjectReport& report) {
  const core::ChangedObject& o = report.object;
  constexpr std::uint64_t kMax = std::numeric_limits<std::int64_t>::max();
  if (o.revision > kMax || o.votes > kMax)
    return core::Fail(core::ErrorCode::kInvalidArgument, o.uid + ": a count beyond 63 bits");
  changed_object_t m{};
  m.robot = report.robot;
  m.mission = report.mission;
  m.origin_lat_deg = report.origin.lat_rad * core::kDegFromRad;
  m.origin_lon_deg = report.origin.lon_rad * core::kDegFromRad;
  m.origin_h_m = report.origin.h_ellipsoidal_m;
  m.uid = o.uid;
  m.revision = static_cast<std::int64_t>(o.revision);
  m.state = static_cast<std::int8_t>(o.state);
  m.size_class = static_cast<std::int8_t>(o.size_class);
  unsigned sides = 0;
  for (std::size_t i = 0; i < core::kBoxSides; ++i) sides |= unsigned{o.side_seen[i]} << i;
  m.sides_seen = static_cast<std::int8_t>(sides);
  std::ranges::copy(o.box.centre_m, m.centre_enu_m);
  std::ranges::copy(o.box.size_m, m.size_m);
  m.heading_deg = o.box.heading_rad * core::kDegFromRad;
  m.second_heading_deg = o.second_heading_rad ? *o.second_heading_rad * core::kDegFromRad
                                              : std::numeric_limits<double>::quiet_NaN();
  int next = 0;
  for (int row = 0; row < kParameters; ++row) {
    for (int column = row; column < kParameters; ++column)
      m.covariance[next++] = o.covariance(row, column);
  }
  m.existence_probability = o.existence_probability;
  m.class_probability = o.class_probability;
  m.voxels = o.voxels;
  m.votes = static_cast<std::int64_t>(o.votes);
  m.last_absent_ns = o.last_absent.ns();
  m.first_seen_ns = o.first_seen.ns();
  m.last_seen_ns = o.last_seen.ns();
  m.gone_ns = o.gone.ns();
  m.seen_by = o.robots;
  m.n_seen_by = static_cast<std::int32_t>(o.robots.size());
  if (static_cast<std::size_t>(m.getEncodedSize()) > kMaxObjectBytes)
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      o.uid + ": " + std::to_string(m.getEncodedSize()) + " bytes, " +
                          std::to_string(kMaxObjectBytes) +
                          " pass (fewer robots, or shorter names)");
  return m;
}

core::Expected<ObjectReport> FromMessage(const changed_object_t& m) {
  if (const char* fault = Fault(m)) return Bad(fault);
  ObjectReport report;
  report.robot = m.robot;
  report.mission = m.mission;
  report.origin = {m.origin_lat_deg * core::kRadFromDeg, m.origin_lon_deg * core::kRadFromDeg,
                   m.origin_h_m};
  core::ChangedObject& o = report.object;
  o.uid = m.uid;
  o.revision = static_cast<std::uint64_t>(m.revision);
  o.state = static_cast<core::ChangeState>(m.state);
  o.size_class = static_cast<core::SizeClass>(m.size_class);
  for (std::size_t i = 0; i < core::kBoxSides; ++i)
    o.side_seen[i] = (static_cast<unsigned>(m.sides_seen) >> i & 1U) != 0;
  o.box.centre_m = {m.centre_enu_m[0], m.centre_enu_m[1], m.centre_enu_m[2]};
  o.box.size_m = {m.size_m[0], m.size_m[1], m.size_m[2]};
  o.box.heading_rad = m.heading_deg * core::kRadFromDeg;
  if (!std::isnan(m.second_heading_deg))
    o.second_heading_rad = m.second_heading_deg * core::kRadFromDeg;
  int next = 0;
  for (int row = 0; row < kParameters; ++row) {
    for (int column = row; column < kParameters; ++column)
      o.covariance(row, column) = o.covariance(column, row) = m.covariance[next++];
  }
  o.existence_probability = m.existence_probability;
  o.class_probability = m.class_probability;
  o.voxels = static_cast<std::uint32_t>(m.voxels);
  o.votes = static_cast<std::uint64_t>(m.votes);
  o.last_absent = core::UtcTime::FromNs(m.last_absent_ns);
  o.first_seen = core::UtcTime::FromNs(m.first_seen_ns);
  o.last_seen = core::UtcTime::FromNs(m.last_seen_ns);
  o.gone = core::UtcTime::FromNs(m.gone_ns);
  o.robots = m.seen_by;
  return report;
}

}  // namespace kawara::comms
