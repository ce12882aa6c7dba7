#include "station/intake.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/config/tree.hpp"
#include "gis/record_check.hpp"

namespace kawara::station {
namespace {

constexpr std::size_t kMostUnclaimed = 10000;
constexpr std::size_t kMostSequences = 64;
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

void Intake::Announce(const std::string& robot, const std::string& mission) {
  if (robot == robot_ && mission == mission_) return;
  robot_ = robot;
  mission_ = mission;
  for (Item& item : std::exchange(unclaimed_, {})) {
    auto record = std::get<gis::PoseRecord>(std::move(item.record));
    record.robot = robot_;
    record.mission = mission_;
    Hand(std::move(record), item.received);
  }
}

void Intake::Hand(gis::PoseRecord record, core::MonoTime received) {
  ++stats_.poses_kept;
  sink_({.record = std::move(record), .received = received});
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
  record.reason = static_cast<gis::PictureReason>(static_cast<std::uint8_t>(packet.reason));
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
  Announce(record.robot, record.mission);
  Sequence& sequence = SequenceOf(record.robot, record.mission);
  const bool full = record.stage == gis::PictureStage::kFull;
  (full ? sequence.pictures : sequence.previews).Take(record.epoch);
  ++(full ? stats_.pictures : stats_.previews);
  sink_({.record = std::move(record), .received = received});
}

void Intake::OnPose(const pose_t& pose, bool at_exposure, core::MonoTime received) {
  ++stats_.poses;
  if (!pose.valid) {
    ++stats_.poses_invalid;
    return;
  }
  gis::PoseRecord record{
      .robot = "?", .mission = "?", .pose = FieldsOf(pose), .at_exposure = at_exposure};
  if (auto checked = gis::CheckRecord(record); !checked)
    return Refuse("POSE", checked.error().message);
  if (!at_exposure) {
    if (config_.pose_rate_hz <= 0.0) return;
    const auto period_ns = static_cast<std::int64_t>(
        std::llround(std::min(1e9 / config_.pose_rate_hz, kLongestPeriodNs)));
    const std::int64_t gap_ns = pose.gps_ns - std::exchange(last_pose_ns_, pose.gps_ns);
    const std::int64_t slot = pose.gps_ns / period_ns;
    const bool entered = slot > std::exchange(last_slot_, slot);
    if (!entered || gap_ns > kMostSilenceNs) return;
  }
  if (!robot_.empty()) {
    record.robot = robot_;
    record.mission = mission_;
    return Hand(std::move(record), received);
  }
  unclaimed_.push_back({.record = std::move(record), .received = received});
  if (unclaimed_.size() > kMostUnclaimed) {
    unclaimed_.pop_front();
    ++stats_.unclaimed_poses;
  }
}

void Intake::OnEvent(const event_t& event, core::MonoTime received) {
  gis::EventRecord record;
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

void Intake::OnConfig(const config_t& config) {
  if (config.program != "kawara-onboard") return;
  core::config::Problems problems;
  const auto root = core::config::ParseYaml(config.yaml, "CONFIG", problems);
  const auto* robot = root.Find("robot");
  const auto text = [robot](const char* key) {
    const auto* node = robot != nullptr ? robot->Find(key) : nullptr;
    return node != nullptr ? node->text : std::string();
  };
  const std::string name = text("name");
  const std::string mission = text("mission");
  const auto usable = [](const std::string& s) {
    return !s.empty() && gis::IsCleanText(s, gis::kMaxNameBytes);
  };
  if (usable(name) && usable(mission)) return Announce(name, mission);
  // The onboard program has (re)started and its mission is not known: poses wait for its first
  // picture.
  robot_.clear();
  mission_.clear();
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

void Intake::Finish() {
  if (unclaimed_.empty()) return;
  const auto& first = std::get<gis::PoseRecord>(unclaimed_.front().record).pose;
  const core::CivilTime c = core::ToCivil(core::ToUtc(first.time));
  std::array<char, 64> mission{};
  std::snprintf(mission.data(), mission.size(), "%04d%02d%02dT%02d%02d%02dZ", c.year, c.month,
                c.day, c.hour, c.minute, c.second);
  Announce("unknown", mission.data());
}

Intake::Sequence& Intake::SequenceOf(const std::string& robot, const std::string& mission) {
  const auto found = std::find_if(sequences_.begin(), sequences_.end(), [&](const Sequence& s) {
    return s.robot == robot && s.mission == mission;
  });
  if (found != sequences_.end()) {
    sequences_.splice(sequences_.begin(), sequences_, found);
    return sequences_.front();
  }
  sequences_.push_front({.robot = robot, .mission = mission, .previews = {}, .pictures = {}});
  if (sequences_.size() > kMostSequences) {
    forgotten_missing_ += sequences_.back().pictures.missing();
    sequences_.pop_back();
  }
  return sequences_.front();
}

std::int64_t Intake::missing_pictures() const {
  std::int64_t sum = forgotten_missing_;
  for (const Sequence& s : sequences_) sum += s.pictures.missing();
  return sum;
}

std::int64_t Intake::missing_previews() const {
  std::int64_t sum = 0;
  for (const Sequence& s : sequences_) sum += s.previews.missing();
  return sum;
}

std::int64_t Intake::late_pictures() const {
  std::int64_t sum = 0;
  for (const Sequence& s : sequences_) sum += s.pictures.late();
  return sum;
}

std::string Intake::RobotLosses() const {
  std::string text;
  for (const auto& [name, value] : losses_)
    if (value != 0) text += (text.empty() ? "" : ", ") + name + " " + std::to_string(value);
  return text;
}

}  // namespace kawara::station
