#include <charconv>
#include <cmath>
#include <cstdio>

#include "vision/panorama_blocks.hpp"

// GPano: Google, "Photo Sphere XMP Metadata". PoseHeading is the compass heading of the image
// centre, PosePitch the elevation of the centre, PoseRoll grows as the horizon turns
// counter-clockwise: the signs of forward-right-down pitch and roll.
//
// Our own namespace (kKawaraNamespace); numbers in plain decimal notation, lists separated by one
// space:
//   Time                   UTC of mid-exposure, ISO 8601, nanoseconds
//   Latitude, Longitude    degrees, WGS 84, 12 decimals
//   EllipsoidalHeight      metres above the ellipsoid; GeoidSeparation: metres, if known
//   PositionCovarianceENU  m^2: ee en eu nn nu uu
//   RtkState               none autonomous dgps float fixed dead-reckoning
//   GnssAge                s since the last fix used; Hdop
//   Heading, Pitch, Roll   degrees, of the picture; AttitudeSd: degrees, roll pitch yaw
//   Robot, Mission, Epoch  which picture this is
namespace kawara::vision {
namespace {

std::optional<double> Number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<std::int64_t> Integer(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

// `count` numbers separated by spaces.
std::optional<std::vector<double>> Numbers(std::string_view text, std::size_t count) {
  std::vector<double> values;
  while (!text.empty() && values.size() < count) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const auto value = Number(text.substr(0, end));
    if (!value) return {};
    values.push_back(*value);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (values.size() != count || !text.empty()) return {};
  return values;
}

std::string Shortest(double value) {
  char text[40];
  const auto result = std::to_chars(text, text + sizeof text, value);
  return {text, result.ptr};
}

double HeadingDegrees(double yaw_rad, int decimals) {
  const double scale = std::pow(10.0, decimals);
  double degrees = std::round(yaw_rad * core::kDegFromRad * scale) / scale;
  if (degrees < 0.0) degrees += 360.0;
  return degrees >= 360.0 ? degrees - 360.0 : degrees;
}

constexpr struct {
  std::string_view name;
  int PanoramaGeometry::*field;
} kGeometryFields[] = {
    {"CroppedAreaImageWidthPixels", &PanoramaGeometry::width_px},
    {"CroppedAreaImageHeightPixels", &PanoramaGeometry::height_px},
    {"FullPanoWidthPixels", &PanoramaGeometry::full_width_px},
    {"FullPanoHeightPixels", &PanoramaGeometry::full_height_px},
    {"CroppedAreaLeftPixels", &PanoramaGeometry::left_px},
    {"CroppedAreaTopPixels", &PanoramaGeometry::top_px},
};

void AddGPano(const PanoramaMetadata& m, std::vector<XmpProperty>* out) {
  const auto add = [&](std::string_view name, std::string value) {
    out->push_back({kGPanoNamespace, name, std::move(value)});
  };
  add("ProjectionType", "equirectangular");
  add("UsePanoramaViewer", "True");
  for (const auto& [name, field] : kGeometryFields) add(name, std::to_string(m.geometry.*field));
  if (m.attitude) {
    add("PoseHeadingDegrees", FixedText(HeadingDegrees(m.attitude->yaw_rad, 4), 4));
    add("PosePitchDegrees", FixedText(m.attitude->pitch_rad * core::kDegFromRad, 4));
    add("PoseRollDegrees", FixedText(m.attitude->roll_rad * core::kDegFromRad, 4));
    add("InitialViewHeadingDegrees", FixedText(HeadingDegrees(m.attitude->yaw_rad, 0), 0));
    add("InitialViewPitchDegrees", "0");
    add("InitialViewRollDegrees", "0");
  }
  if (m.time) {
    add("FirstPhotoDate", IsoTime(*m.time));
    add("LastPhotoDate", IsoTime(*m.time));
  }
  add("SourcePhotosCount", "1");
  if (!m.software.empty()) add("StitchingSoftware", m.software);
}

void AddOwn(const PanoramaMetadata& m, std::vector<XmpProperty>* out) {
  const auto add = [&](std::string_view name, std::string value) {
    out->push_back({kKawaraNamespace, name, std::move(value)});
  };
  const auto add_if_known = [&](std::string_view name, double value) {
    if (std::isfinite(value)) add(name, Shortest(value));
  };
  if (m.time) add("Time", IsoTime(*m.time));
  if (m.position) {
    add("Latitude", FixedText(m.position->lat_rad * core::kDegFromRad, 12));
    add("Longitude", FixedText(m.position->lon_rad * core::kDegFromRad, 12));
    add("EllipsoidalHeight", FixedText(m.position->h_ellipsoidal_m, 5));
    add_if_known("GeoidSeparation", m.geoid_separation_m);
    const Eigen::Matrix3d& c = m.position_cov_enu_m2;
    if (c.allFinite() && !c.isZero(0.0)) {
      add("PositionCovarianceENU", Shortest(c(0, 0)) + " " + Shortest(c(0, 1)) + " " +
                                       Shortest(c(0, 2)) + " " + Shortest(c(1, 1)) + " " +
                                       Shortest(c(1, 2)) + " " + Shortest(c(2, 2)));
    }
    add("RtkState", core::ToString(m.rtk));
    add_if_known("GnssAge", m.gnss_age_s);
    add_if_known("Hdop", m.hdop);
  }
  if (m.attitude) {
    add("Heading", FixedText(HeadingDegrees(m.attitude->yaw_rad, 7), 7));
    add("Pitch", FixedText(m.attitude->pitch_rad * core::kDegFromRad, 7));
    add("Roll", FixedText(m.attitude->roll_rad * core::kDegFromRad, 7));
    const Eigen::Vector3d sd_deg = m.attitude_sd_rad * core::kDegFromRad;
    if (sd_deg.allFinite() && !sd_deg.isZero(0.0)) {
      add("AttitudeSd",
          Shortest(sd_deg.x()) + " " + Shortest(sd_deg.y()) + " " + Shortest(sd_deg.z()));
    }
  }
  if (!m.robot.empty()) add("Robot", m.robot);
  if (!m.mission.empty()) add("Mission", m.mission);
  if (m.epoch != 0) add("Epoch", std::to_string(m.epoch));
}

using Properties = std::vector<std::pair<std::string, std::string>>;

std::optional<std::string> Text(const Properties& properties, std::string_view name) {
  for (const auto& [key, value] : properties) {
    if (key == name) return value;
  }
  return {};
}

std::optional<double> Number(const Properties& properties, std::string_view name) {
  const auto text = Text(properties, name);
  return text ? Number(*text) : std::nullopt;
}

void ReadGPano(const Properties& gpano, PanoramaMetadata* m) {
  PanoramaGeometry geometry;
  bool complete = true;
  for (const auto& [name, field] : kGeometryFields) {
    const auto text = Text(gpano, name);
    const auto value = text ? Integer(*text) : std::nullopt;
    if (value && *value >= 0 && *value <= 1'000'000) {
      geometry.*field = static_cast<int>(*value);
    } else {
      complete = false;
    }
  }
  if (complete) m->geometry = geometry;
  const auto heading = Number(gpano, "PoseHeadingDegrees");
  if (heading || m->attitude) {
    const double yaw_rad =
        heading ? core::WrapPi(*heading * core::kRadFromDeg) : m->attitude->yaw_rad;
    m->attitude = core::Attitude{
        Number(gpano, "PoseRollDegrees").value_or(0.0) * core::kRadFromDeg,
        Number(gpano, "PosePitchDegrees").value_or(0.0) * core::kRadFromDeg, yaw_rad};
  }
}

void ReadOwn(const Properties& own, PanoramaMetadata* m) {
  if (const auto text = Text(own, "Time")) {
    if (const auto time = ParseIsoTime(*text)) m->time = time;
  }
  const auto lat = Number(own, "Latitude"), lon = Number(own, "Longitude"),
             h = Number(own, "EllipsoidalHeight");
  if (lat && lon && h) {
    m->position = core::Geodetic{*lat * core::kRadFromDeg, *lon * core::kRadFromDeg, *h};
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    m->geoid_separation_m = Number(own, "GeoidSeparation").value_or(unknown);
    m->gnss_age_s = Number(own, "GnssAge").value_or(unknown);
    m->hdop = Number(own, "Hdop").value_or(unknown);
  }
  if (const auto text = Text(own, "PositionCovarianceENU")) {
    if (const auto c = Numbers(*text, 6)) {
      m->position_cov_enu_m2 << (*c)[0], (*c)[1], (*c)[2], (*c)[1], (*c)[3], (*c)[4], (*c)[2],
          (*c)[4], (*c)[5];
    }
  }
  if (const auto text = Text(own, "RtkState")) {
    for (int state = 0; state <= static_cast<int>(core::RtkState::kDeadReckoning); ++state) {
      if (*text == core::ToString(static_cast<core::RtkState>(state)))
        m->rtk = static_cast<core::RtkState>(state);
    }
  }
  const auto heading = Number(own, "Heading"), pitch = Number(own, "Pitch"),
             roll = Number(own, "Roll");
  if (heading && pitch && roll) {
    m->attitude = core::Attitude{*roll * core::kRadFromDeg, *pitch * core::kRadFromDeg,
                                 core::WrapPi(*heading * core::kRadFromDeg)};
  }
  if (const auto text = Text(own, "AttitudeSd")) {
    if (const auto sd = Numbers(*text, 3)) {
      m->attitude_sd_rad = Eigen::Vector3d((*sd)[0], (*sd)[1], (*sd)[2]) * core::kRadFromDeg;
    }
  }
  m->robot = Text(own, "Robot").value_or("");
  m->mission = Text(own, "Mission").value_or("");
  if (const auto text = Text(own, "Epoch")) m->epoch = Integer(*text).value_or(0);
}

}  // namespace

std::string FixedText(double value, int decimals) {
  char text[400];
  const auto result =
      std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals);
  return {text, result.ptr};
}

std::string IsoTime(core::UtcTime time) {
  const core::CivilTime c = core::ToCivil(time);
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02d-%02dT%02d:%02d:%02d.%09dZ", c.year, c.month, c.day,
                c.hour, c.minute, c.second, static_cast<int>(c.nanosecond));
  return text;
}

std::optional<core::UtcTime> ParseIsoTime(std::string_view text) {
  constexpr std::string_view kShape = "0000-00-00T00:00:00.000000000Z";
  if (text.size() != kShape.size()) return {};
  std::int64_t numbers[7] = {};
  int field = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool digit = text[i] >= '0' && text[i] <= '9';
    if (digit != (kShape[i] == '0') || (!digit && text[i] != kShape[i])) return {};
    if (digit) {
      numbers[field] = numbers[field] * 10 + (text[i] - '0');
    } else if (field < 6) {
      ++field;
    }
  }
  const core::CivilTime c{static_cast<int>(numbers[0]),         static_cast<int>(numbers[1]),
                          static_cast<int>(numbers[2]),         static_cast<int>(numbers[3]),
                          static_cast<int>(numbers[4]),         static_cast<int>(numbers[5]),
                          static_cast<std::int32_t>(numbers[6])};
  if (!core::IsValid(c) || c.year < 1970 || c.year > 2200) return {};
  return core::FromCivil(c);
}

std::vector<XmpProperty> XmpProperties(const PanoramaMetadata& metadata) {
  std::vector<XmpProperty> properties;
  if (metadata.geometry.width_px > 0) AddGPano(metadata, &properties);
  AddOwn(metadata, &properties);
  return properties;
}

void ReadXmpTags(std::string_view packet, PanoramaMetadata* metadata) {
  ReadGPano(ReadXmpProperties(packet, kGPanoNamespace), metadata);
  ReadOwn(ReadXmpProperties(packet, kKawaraNamespace), metadata);
}

}  // namespace kawara::vision
