#include "gis/rows.hpp"

#include <ogr_feature.h>
#include <ogr_geometry.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "gis/schema.hpp"

namespace kawara::gis {
namespace {

constexpr double kPerDegPosition = 1e10;
constexpr double kPerDegAngle = 1e6;
constexpr double kPerMetre = 1e4;
constexpr double kPerSecond = 1e3;

double Rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }

void SetReal(OGRFeature& f, const char* name, double value, double per_unit) {
  if (std::isfinite(value)) {
    f.SetField(name, Rounded(value, per_unit) + 0.0);  // + 0.0: minus zero is zero
  } else {
    f.SetFieldNull(f.GetFieldIndex(name));
  }
}

void SetInteger(OGRFeature& f, const char* name, std::int64_t value) {
  f.SetField(name, static_cast<GIntBig>(value));
}

void SetTime(OGRFeature& f, const char* name, core::GpsTime t) {
  const core::CivilTime c = core::ToCivil(UtcOf(t));
  constexpr int kUtcFlag = 100;
  const int ms = c.nanosecond / 1'000'000;  // rounded down, as IsoUtc
  f.SetField(f.GetFieldIndex(name), c.year, c.month, c.day, c.hour, c.minute,
             static_cast<float>(c.second) + static_cast<float>(ms) / 1000.0F, kUtcFlag);
}

void SetPoint(OGRFeature& f, const PoseFields& pose) {
  const TrackVertex v = VertexOf(pose);
  f.SetGeometryDirectly(
      std::make_unique<OGRPoint>(v.lon_deg, v.lat_deg, v.h_ellipsoidal_m).release());
}

void FillPose(OGRFeature& f, const PoseFields& p, bool has_position) {
  SetInteger(f, "gps_ns", p.time.ns());
  SetTime(f, "t_begin", p.time);
  f.SetField("rtk_state", core::ToString(has_position ? p.rtk : core::RtkState::kNone));
  if (!has_position) return;
  SetPoint(f, p);
  SetReal(f, "lat_deg", p.lat_deg, kPerDegPosition);
  SetReal(f, "lon_deg", p.lon_deg, kPerDegPosition);
  SetReal(f, "h_ellipsoidal_m", p.h_ellipsoidal_m, kPerMetre);
  SetReal(f, "roll_deg", p.roll_deg, kPerDegAngle);
  SetReal(f, "pitch_deg", p.pitch_deg, kPerDegAngle);
  SetReal(f, "yaw_deg", p.yaw_deg, kPerDegAngle);
  SetReal(f, "v_east_mps", p.velocity_enu_mps[0], kPerMetre);
  SetReal(f, "v_north_mps", p.velocity_enu_mps[1], kPerMetre);
  SetReal(f, "v_up_mps", p.velocity_enu_mps[2], kPerMetre);
  SetReal(f, "sd_east_m", p.position_sd_enu_m[0], kPerMetre);
  SetReal(f, "sd_north_m", p.position_sd_enu_m[1], kPerMetre);
  SetReal(f, "sd_up_m", p.position_sd_enu_m[2], kPerMetre);
  SetReal(f, "sd_roll_deg", p.attitude_sd_deg[0], kPerDegAngle);
  SetReal(f, "sd_pitch_deg", p.attitude_sd_deg[1], kPerDegAngle);
  SetReal(f, "sd_yaw_deg", p.attitude_sd_deg[2], kPerDegAngle);
  SetReal(f, "gnss_age_s", p.gnss_age_s, kPerSecond);
}

/// Along the track in space: chords between neighbours.
double LengthM(const std::vector<TrackVertex>& track) {
  const auto ecef = [](const TrackVertex& v) {
    return core::EcefFromGeodetic(
        {v.lat_deg * core::kRadFromDeg, v.lon_deg * core::kRadFromDeg, v.h_ellipsoidal_m});
  };
  double length_m = 0.0;
  Eigen::Vector3d previous = ecef(track.front());
  for (const TrackVertex& v : track) {
    const Eigen::Vector3d here = ecef(v);
    length_m += (here - previous).norm();
    previous = here;
  }
  return length_m;
}

std::string Crc32(const std::vector<std::uint8_t>& bytes) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%08lx", crc32_z(0, bytes.data(), bytes.size()));
  return text.data();
}

}  // namespace

core::UtcTime UtcOf(core::GpsTime t) { return core::ToUtc(t); }

const char* ToString(PictureStage stage) {
  return stage == PictureStage::kFull ? "full" : "preview";
}

TrackVertex VertexOf(const PoseFields& p) {
  return {p.time.ns(), Rounded(p.lat_deg, kPerDegPosition), Rounded(p.lon_deg, kPerDegPosition),
          Rounded(p.h_ellipsoidal_m, kPerMetre)};
}

void Fill(OGRFeature& f, const PoseRecord& record) {
  f.SetField("robot", record.robot.c_str());
  f.SetField("mission", record.mission.c_str());
  f.SetField("class_code", "obs.pose");
  f.SetField("source", record.at_exposure ? "exposure" : "periodic");
  FillPose(f, record.pose, true);
}

void Fill(OGRFeature& f, const PanoramaRecord& record, const PictureFiles& files) {
  f.SetField("robot", record.robot.c_str());
  f.SetField("mission", record.mission.c_str());
  f.SetField("class_code", "obs.panorama");
  SetInteger(f, "epoch", record.epoch);
  f.SetField("stage", ToString(record.stage));
  f.SetField("reason", ToString(record.reason));
  FillPose(f, record.pose, record.has_position);
  f.SetField("projection", record.projection.c_str());
  SetInteger(f, "width_px", record.width);
  SetInteger(f, "height_px", record.height);
  SetInteger(f, "jpeg_bytes", static_cast<std::int64_t>(record.jpeg->size()));
  f.SetField("crc32", Crc32(*record.jpeg).c_str());
  f.SetField("uri", files.uri.c_str());
  if (files.preview_uri.empty()) {
    f.SetFieldNull(f.GetFieldIndex("preview_uri"));
  } else {
    f.SetField("preview_uri", files.preview_uri.c_str());
  }
}

void Fill(OGRFeature& f, const EventRecord& record) {
  constexpr std::array<const char*, 4> kSeverity{"info", "warn-low", "warn-high", "fatal"};
  f.SetField("robot", record.robot.c_str());
  f.SetField("mission", record.mission.c_str());
  if (record.time.IsSet()) {
    SetTime(f, "t_begin", record.time);
    SetInteger(f, "gps_ns", record.time.ns());
  }
  SetInteger(f, "mono_ns", record.mono.ns());
  f.SetField("severity", kSeverity[static_cast<std::size_t>(record.severity)]);
  f.SetField("name", record.name.c_str());
  f.SetField("text", record.text.c_str());
  SetInteger(f, "suppressed", record.suppressed);
}

void Fill(OGRFeature& f, const std::string& robot, const std::string& mission,
          const std::vector<TrackVertex>& track) {
  const auto first = core::GpsTime::FromNs(track.front().gps_ns);
  const auto last = core::GpsTime::FromNs(track.back().gps_ns);
  f.SetField("robot", robot.c_str());
  f.SetField("mission", mission.c_str());
  f.SetField("class_code", "obs.trajectory");
  SetTime(f, "t_begin", first);
  SetTime(f, "t_end", last);
  SetInteger(f, "first_gps_ns", first.ns());
  SetInteger(f, "last_gps_ns", last.ns());
  SetInteger(f, "poses", static_cast<std::int64_t>(track.size()));
  SetReal(f, "length_m", LengthM(track), kPerSecond);
  auto line = std::make_unique<OGRLineString>();
  line->setNumPoints(static_cast<int>(track.size()), FALSE);
  int i = 0;
  for (const TrackVertex& v : track) {
    const std::int64_t utc_ms = UtcOf(core::GpsTime::FromNs(v.gps_ns)).ns() / 1'000'000;
    line->setPoint(i++, v.lon_deg, v.lat_deg, v.h_ellipsoidal_m,
                   static_cast<double>(utc_ms) / 1000.0);
  }
  f.SetGeometryDirectly(line.release());
}

void SetEnd(OGRFeature& f, core::GpsTime t_end) {
  if (t_end.IsSet()) {
    SetTime(f, "t_end", t_end);
  } else {
    f.SetFieldNull(f.GetFieldIndex("t_end"));
  }
}

}  // namespace kawara::gis
