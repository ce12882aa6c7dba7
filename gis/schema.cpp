#include "gis/schema.hpp"

#include <array>
#include <cstdio>

#include "core/check.hpp"

namespace kawara::gis {
namespace {

using enum FieldType;

constexpr auto kPoseFields = std::to_array<Field>({
    {"robot", kText, true},
    {"mission", kText, true},
    {"class_code", kText, true},
    {"gps_ns", kInteger, true},
    {"t_begin", kTime, true},
    {"t_end", kTime, false},
    {"lat_deg", kReal, false},
    {"lon_deg", kReal, false},
    {"h_ellipsoidal_m", kReal, false},
    {"roll_deg", kReal, false},
    {"pitch_deg", kReal, false},
    {"yaw_deg", kReal, false},
    {"v_east_mps", kReal, false},
    {"v_north_mps", kReal, false},
    {"v_up_mps", kReal, false},
    {"sd_east_m", kReal, false},
    {"sd_north_m", kReal, false},
    {"sd_up_m", kReal, false},
    {"sd_roll_deg", kReal, false},
    {"sd_pitch_deg", kReal, false},
    {"sd_yaw_deg", kReal, false},
    {"rtk_state", kText, true},
    {"gnss_age_s", kReal, false},
    {"source", kText, true},  // "exposure" or "periodic"
});

constexpr auto kPanoramaFields = std::to_array<Field>({
    {"robot", kText, true},         {"mission", kText, true},
    {"class_code", kText, true},    {"epoch", kInteger, true},
    {"stage", kText, true},   // "preview" or "full": what uri shows
    {"reason", kText, true},  // core::PictureReason
    {"gps_ns", kInteger, true},     {"t_begin", kTime, true},
    {"t_end", kTime, false},        {"lat_deg", kReal, false},
    {"lon_deg", kReal, false},      {"h_ellipsoidal_m", kReal, false},
    {"roll_deg", kReal, false},     {"pitch_deg", kReal, false},
    {"yaw_deg", kReal, false},      {"v_east_mps", kReal, false},
    {"v_north_mps", kReal, false},  {"v_up_mps", kReal, false},
    {"sd_east_m", kReal, false},    {"sd_north_m", kReal, false},
    {"sd_up_m", kReal, false},      {"sd_roll_deg", kReal, false},
    {"sd_pitch_deg", kReal, false}, {"sd_yaw_deg", kReal, false},
    {"rtk_state", kText, true},     {"gnss_age_s", kReal, false},
    {"projection", kText, true},    {"width_px", kInteger, true},
    {"height_px", kInteger, true},  {"jpeg_bytes", kInteger, true},
    {"crc32", kText, true},         // of the file uri names, 8 hexadecimal digits
    {"uri", kText, true},           // relative to the folder of the store
    {"preview_uri", kText, false},  // the preview stays as the picture's thumbnail
});

constexpr auto kTrajectoryFields = std::to_array<Field>({
    {"robot", kText, true},
    {"mission", kText, true},
    {"class_code", kText, true},
    {"t_begin", kTime, true},
    {"t_end", kTime, true},
    {"first_gps_ns", kInteger, true},
    {"last_gps_ns", kInteger, true},
    {"poses", kInteger, true},
    {"length_m", kReal, true},
});

constexpr auto kEventFields = std::to_array<Field>({
    {"robot", kText, true},
    {"mission", kText, true},
    {"t_begin", kTime, false},
    {"gps_ns", kInteger, false},
    {"mono_ns", kInteger, true},
    {"severity", kText, true},  // "info", "warn-low", "warn-high", "fatal"
    {"name", kText, true},
    {"text", kText, true},
    {"suppressed", kInteger, true},
});

constexpr auto kSchema = std::to_array<LayerSchema>({
    {kObsPose, "Poses of the robots", GeometryKind::kPointZ, kPoseFields, "robot, mission, gps_ns",
     "gps_ns", "robot, gps_ns"},
    {kObsPanorama, "Omnidirectional pictures (1st update)", GeometryKind::kPointZ, kPanoramaFields,
     "robot, mission, epoch", "epoch", "robot, gps_ns"},
    {kTrajectory, "Tracks of the robots", GeometryKind::kLineStringZm, kTrajectoryFields,
     "robot, mission", "first_gps_ns", ""},
    {kEventLog, "Events the robots reported", GeometryKind::kNone, kEventFields,
     "robot, mission, mono_ns, name, text", "mono_ns", ""},
});

}  // namespace

std::span<const LayerSchema> Schema() { return kSchema; }

const LayerSchema& LayerByName(const std::string& name) {
  for (const LayerSchema& layer : kSchema) {
    if (name == layer.name) return layer;
  }
  constexpr bool kThereIsSuchALayer = false;
  CORE_CHECK(kThereIsSuchALayer);
  return kSchema.front();
}

std::string IsoUtc(core::UtcTime t) {
  const core::CivilTime c = core::ToCivil(t);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02d-%02dT%02d:%02d:%02d.%03dZ", c.year, c.month,
                c.day, c.hour, c.minute, c.second, c.nanosecond / 1'000'000);
  return text.data();
}

std::string SqlText(const std::string& text) {
  std::string sql = "'";
  for (const char c : text) {
    sql += c;
    if (c == '\'') sql += c;
  }
  return sql + "'";
}

}  // namespace kawara::gis
