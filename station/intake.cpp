#include "station/intake.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "gis/kiwi/check_object.hpp"
#include "gis/record_check.hpp"

namespace kawara::station {
namespace {

constexpr std::size_t kMostMissions = 64;
constexpr std::size_t kMostLosses = 256;
constexpr double kLongestPeriodNs = 1e15;
constexpr std::int64_t kMostSilenceNs = 3'000'000'000;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// NaN for what is no variance: unknown, negative or infinite.
double SdOf(double variance) {
  return std::isfinite(variance) && variance >= 0.0 ? std::sqrt(variance) : kNan;
}
double FiniteOrNan(double v) { return std::isfinite(v) ? v : kNan; }

gis::PoseFields FieldsOf(const pose_t& p) {
  gis::PoseFields f;
  f.time = core::GpsTime::FromNs(p.gps_ns);
  f.lat_deg = p.lat_deg;
  f.lon_deg = p.lon_deg;
  f.h_ellipsoidal_m = p.h_ellipsoidal_m;
  f.roll_deg = p.roll_deg;
  f.pitch_deg = p.pitch_deg;
  f.yaw_deg = p.yaw_deg;
  for (std::size_t i = 0; i < 3; ++i) {
    f.velocity_enu_mps[i] = FiniteOrNan(p.velocity_enu_mps[i]);
    f.position_sd_enu_m[i] = SdOf(p.position_cov_enu_m2[4 * i]);
    const double sd_deg = p.attitude_sd_deg[i];
    f.attitude_sd_deg[i] = sd_deg >= 0.0 ? FiniteOrNan(sd_deg) : kNan;
  }
  f.rtk = static_cast<core::RtkState>(static_cast<std::uint8_t>(p.rtk_state));
  f.gnss_age_s = FiniteOrNan(p.gnss_age_s);
  return f;
}

}  // namespace

Intake::Intake(const StationConfig& config, Sink sink) : config_(config), sink_(std::move(sink)) {}

void Intake::Refuse(const std::string& what, const std::string& why) {
  ++stats_.refused;
  stats_.last_refusal = what + ": " + why;
}

void Intake::OnPhase1(const phase1_t& packet, core::MonoTime received) {
  if (static_cast<double>(packet.jpeg.size()) > config_.max_picture_mb * 1e6)
    return Refuse("PHASE1", std::to_string(packet.jpeg.size()) +
                                " bytes of JPEG, max_picture_mb is " +
                                std::to_string(config_.max_picture_mb));
  gis::PanoramaRecord record;
  record.robot = packet.robot;
  record.mission = packet.mission;
  record.epoch = packet.epoch;
  record.stage = static_cast<gis::PictureStage>(static_cast<std::uint8_t>(packet.stage));
  record.reason = static_cast<core::PictureReason>(static_cast<std::uint8_t>(packet.reason));
  record.has_position = packet.pose.valid;
  record.pose = FieldsOf(packet.pose);
  record.projection = packet.projection;
  record.width = static_cast<std::uint32_t>(std::max(packet.width, 0));
  record.height = static_cast<std::uint32_t>(std::max(packet.height, 0));
  record.jpeg = std::make_shared<const std::vector<std::uint8_t>>(packet.jpeg);
  if (auto checked = gis::CheckRecord(record); !checked)
    return Refuse("PHASE1", checked.error().message);
  if (packet.gps_minus_utc_s != core::LeapSeconds().OffsetAt(record.pose.time))
    ++stats_.leap_mismatch;
  Mission& mission = MissionOf(record.robot, record.mission);
  const bool full = record.stage == gis::PictureStage::kFull;
  (full ? mission.pictures : mission.previews).Take(record.epoch);
  ++(full ? stats_.pictures : stats_.previews);
  sink_({.record = std::move(record), .received = received});
}

void Intake::OnPose(const robot_pose_t& message, bool at_exposure, core::MonoTime received) {
  ++stats_.poses;
  if (!message.pose.valid) {
    ++stats_.poses_invalid;
    return;
  }
  gis::PoseRecord record{.robot = message.robot,
                         .mission = message.mission,
                         .pose = FieldsOf(message.pose),
                         .at_exposure = at_exposure};
  if (auto checked = gis::CheckRecord(record); !checked)
    return Refuse("POSE", checked.error().message);
  if (!at_exposure && !IsFirstOfItsPeriod(record)) return;
  ++stats_.poses_kept;
  sink_({.record = std::move(record), .received = received});
}

bool Intake::IsFirstOfItsPeriod(const gis::PoseRecord& record) {
  if (config_.pose_rate_hz <= 0.0) return false;
  const auto period_ns = static_cast<std::int64_t>(
      std::llround(std::min(1e9 / config_.pose_rate_hz, kLongestPeriodNs)));
  Mission& mission = MissionOf(record.robot, record.mission);
  const std::int64_t gps_ns = record.pose.time.ns();
  const std::int64_t gap_ns = gps_ns - std::exchange(mission.last_pose_ns, gps_ns);
  const std::int64_t slot = gps_ns / period_ns;
  const bool entered = slot > std::exchange(mission.last_slot, slot);
  return entered && gap_ns <= kMostSilenceNs;
}

void Intake::OnEvent(const event_t& event, core::MonoTime received) {
  gis::EventRecord record;
  record.robot = event.robot;
  record.mission = event.mission;
  record.mono = core::MonoTime::FromNs(event.mono_ns);
  record.time = core::GpsTime::FromNs(event.gps_ns);
  record.severity = event.severity;
  record.name = gis::CleanText(event.name, gis::kMaxNameBytes);
  record.text = gis::CleanText(event.text, gis::kMaxTextBytes);
  record.suppressed = event.suppressed;
  if (auto checked = gis::CheckRecord(record); !checked)
    return Refuse("EVENT", checked.error().message);
  ++stats_.events;
  sink_({.record = std::move(record), .received = received});
}

void Intake::OnCounters(const counters_t& counters) {
  for (std::size_t i = 0; i < counters.name.size() && i < counters.value.size(); ++i) {
    const std::string& name = counters.name[i];
    const bool loss = name.find("drop") != std::string::npos ||
                      name.find("lost") != std::string::npos ||
                      name.find("expired") != std::string::npos;
    if (!loss || !gis::IsCleanText(name, gis::kMaxNameBytes)) continue;
    if (losses_.size() < kMostLosses || losses_.contains(name)) losses_[name] = counters.value[i];
  }
}

bool Intake::AreNames(const std::string& what, const std::string& robot,
                      const std::string& mission) {
  for (const std::string& name : {robot, mission}) {
    if (!name.empty() && gis::IsCleanText(name, gis::kMaxNameBytes)) continue;
    Refuse(what, "robot and mission need names of 1..64 clean bytes");
    return false;
  }
  return true;
}

void Intake::OnObject(const changed_object_t& message, core::MonoTime received) {
  auto report = comms::FromMessage(message);
  if (!report) return Refuse("OBJECT", report.error().message);
  if (!AreNames("OBJECT", report->robot, report->mission)) return;
  if (auto checked = gis::CheckObject(report->object); !checked)
    return Refuse("OBJECT", checked.error().message);
  ++stats_.objects;
  sink_({.record = std::move(*report), .received = received});
}

void Intake::OnTexture(const object_texture_t& message, core::MonoTime received) {
  if (!AreNames("OBJECT.TEXTURE", message.robot, message.mission)) return;
  auto whole = atlases_.Add(message);
  if (!whole) return Refuse("OBJECT.TEXTURE", whole.error().message);
  if (!*whole) return;
  if (auto checked = gis::CheckTextures((*whole)->textures); !checked)
    return Refuse("OBJECT.TEXTURE", checked.error().message);
  ++stats_.textures;
  sink_({.record = std::move(**whole), .received = received});
}

void Intake::OnRoad(const road_stations_t& message, core::MonoTime received) {
  auto report = comms::FromMessage(message);
  if (!report) return Refuse("ROAD", report.error().message);
  if (!AreNames("ROAD", report->robot, report->mission)) return;
  for (const core::RoadStation& station : report->stations) {
    auto checked = gis::CheckStation(station);
    if (checked && station.observed.IsSet()) continue;
    return Refuse("ROAD", checked ? "a station that nobody observed" : checked.error().message);
  }
  stats_.stations += static_cast<std::int64_t>(report->stations.size());
  sink_({.record = std::move(*report), .received = received});
}

Intake::Mission& Intake::MissionOf(const std::string& robot, const std::string& name) {
  const auto found = std::find_if(missions_.begin(), missions_.end(), [&](const Mission& m) {
    return m.robot == robot && m.name == name;
  });
  if (found != missions_.end()) {
    missions_.splice(missions_.begin(), missions_, found);
    return missions_.front();
  }
  missions_.emplace_front();
  missions_.front().robot = robot;
  missions_.front().name = name;
  if (missions_.size() > kMostMissions) {
    forgotten_missing_ += missions_.back().pictures.missing();
    missions_.pop_back();
  }
  return missions_.front();
}

std::int64_t Intake::missing_pictures() const {
  std::int64_t sum = forgotten_missing_;
  for (const Mission& m : missions_) sum += m.pictures.missing();
  return sum;
}

std::int64_t Intake::missing_previews() const {
  std::int64_t sum = 0;
  for (const Mission& m : missions_) sum += m.previews.missing();
  return sum;
}

std::int64_t Intake::late_pictures() const {
  std::int64_t sum = 0;
  for (const Mission& m : missions_) sum += m.pictures.late();
  return sum;
}

std::string Intake::RobotLosses() const {
  std::string text;
  for (const auto& [name, value] : losses_)
    if (value != 0) text += (text.empty() ? "" : ", ") + name + " " + std::to_string(value);
  return text;
}

}  // namespace kawara::station
