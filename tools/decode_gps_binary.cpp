#include "tools/decode_gps.hpp"

namespace kawara::tools {
namespace {

using namespace drivers;  // the message types, all of them

void Vector(JsonLines& out, std::string_view key, const Eigen::Vector3d& v, int decimals) {
  out.OpenArray(key);
  for (int i = 0; i < 3; ++i) out.Number("", v[i], decimals);
  out.CloseArray();
}

void Write(JsonLines& out, const AshtechPbn& m) {
  out.Number("gps_time_of_week_s", core::ToSeconds(m.time_of_week), 3);
  out.Text("site", {m.site.data(), m.site.size()});
  Vector(out, "ecef_m", m.ecef_m, 4);
  out.Number("clock_offset_m", m.clock_offset_m, 4);
  Vector(out, "velocity_ecef_mps", m.velocity_ecef_mps, 6);
  out.Number("clock_drift_mps", m.clock_drift_mps, 6);
  out.Number("pdop", m.pdop, 2);
}

struct Rtcm3Writer {
  JsonLines& out;
  void operator()(const std::monostate&) const {}
  void operator()(const Rtcm3Observations& m) const {
    out.Text("system", ToString(m.system));
    if (m.msm != 0) out.Unsigned("msm", m.msm);
    const char* scale = m.system == GnssSystem::kGlonass  ? "glonass_time_of_day_s"
                        : m.system == GnssSystem::kBeidou ? "beidou_time_of_week_s"
                                                          : "gps_time_of_week_s";
    out.Number(scale, core::ToSeconds(m.time_sent), 3);
    if (m.glonass_day_of_week >= 0) out.Integer("glonass_day_of_week", m.glonass_day_of_week);
    out.Unsigned("satellites", m.satellites);
    out.Unsigned("signals", m.signals);
    out.Unsigned("observations", m.observations);
    out.Boolean("more_follow", m.more_follow);
  }
  void operator()(const Rtcm3Station& m) const {
    Vector(out, "ecef_m", m.ecef_m, 4);
    if (m.has_antenna_height) out.Number("antenna_height_m", m.antenna_height_m, 4);
    out.Boolean("gps", m.gps);
    out.Boolean("glonass", m.glonass);
    out.Boolean("galileo", m.galileo);
    out.Boolean("virtual", m.virtual_station);
    out.Unsigned("itrf_year", m.itrf_year);
  }
  void operator()(const Rtcm3Descriptor& m) const {
    out.Text("antenna", m.antenna);
    out.Unsigned("antenna_setup", m.antenna_setup);
    out.Text("antenna_serial", m.antenna_serial);
    out.Text("receiver", m.receiver);
    out.Text("receiver_firmware", m.receiver_firmware);
    out.Text("receiver_serial", m.receiver_serial);
  }
  void operator()(const Rtcm3GlonassBiases& m) const {
    out.Boolean("aligned", m.aligned);
    out.OpenArray("bias_m");
    for (const double bias : m.bias_m) out.Number("", bias, 2);
    out.CloseArray();
  }
  void operator()(const Rtcm3Ephemeris& m) const {
    out.Text("system", ToString(m.system));
    out.Unsigned("satellite", m.satellite);
  }
  void operator()(const Rtcm3SystemParameters& m) const {
    out.Unsigned("modified_julian_day", m.modified_julian_day);
    out.Unsigned("second_of_day", m.second_of_day);
    out.Unsigned("leap_seconds", m.leap_seconds);
    out.OpenArray("announced");
    for (std::size_t i = 0; i < std::min<std::size_t>(m.announced, m.announcements.size()); ++i) {
      out.OpenObject("");
      out.Unsigned("message", m.announcements[i].type);
      out.Boolean("synchronous", m.announcements[i].synchronous);
      out.Number("interval_s", m.announcements[i].interval_s, 1);
      out.CloseObject();
    }
    out.CloseArray();
  }
  void operator()(const Rtcm3Text& m) const {
    out.Unsigned("modified_julian_day", m.modified_julian_day);
    out.Unsigned("second_of_day", m.second_of_day);
    out.Text("text", m.utf8);
  }
};

void Write(JsonLines& out, const Rtcm3Message& m) {
  out.Unsigned("message", m.type);
  out.Unsigned("length", m.length);
  if (m.has_station) out.Unsigned("station", m.station);
  std::visit(Rtcm3Writer{out}, m.body);
}

struct Rtcm2Writer {
  JsonLines& out;
  void operator()(const std::monostate&) const {}
  void operator()(const Rtcm2Corrections& m) const {
    out.Text("system", m.glonass ? "GLONASS" : "GPS");
    out.OpenArray("corrections");
    for (std::size_t i = 0; i < m.count; ++i) {
      const Rtcm2Corrections::Satellite& s = m.satellites[i];
      out.OpenObject("");
      out.Unsigned("id", s.id);
      out.Unsigned("udre", s.udre);
      out.Number("range_m", s.range_m, 3);
      out.Number("rate_mps", s.rate_mps, 4);
      out.Unsigned("issue", s.issue);
      out.CloseObject();
    }
    out.CloseArray();
  }
  void operator()(const Rtcm2Observations& m) const {
    out.Unsigned("band", m.band);
    out.Number("time_of_second_s", core::ToSeconds(m.time_of_second), 6);
    out.Unsigned("satellites", m.count);
    out.Unsigned("gps_mask", m.gps_mask);
    out.Unsigned("glonass_mask", m.glonass_mask);
    out.Boolean("more_follow", m.more_follow);
  }
  void operator()(const Rtcm2Station& m) const {
    Vector(out, "ecef_m", m.ecef_m, 4);
    out.Boolean("reference_point", m.is_reference_point);
    if (m.has_antenna_height) out.Number("antenna_height_m", m.antenna_height_m, 4);
  }
  void operator()(const Rtcm2StationOffset& m) const {
    Vector(out, "l1_offset_m", m.l1_m, 6);
    if (m.has_l2) Vector(out, "l2_offset_m", m.l2_m, 6);
    if (m.has_antenna_height) out.Number("antenna_height_m", m.antenna_height_m, 4);
  }
  void operator()(const Rtcm2Antenna& m) const {
    out.Text("antenna", m.descriptor());
    out.Unsigned("antenna_setup", m.setup);
    out.Text("antenna_serial", m.serial());
  }
};

void Write(JsonLines& out, const Rtcm2Message& m) {
  out.Unsigned("message", m.type);
  out.Unsigned("station", m.station);
  out.Number("time_of_hour_s", core::ToSeconds(m.time_of_hour), 1);
  out.Unsigned("sequence", m.sequence);
  out.Unsigned("health", m.health);
  out.Unsigned("data_words", m.data_words);
  std::visit(Rtcm2Writer{out}, m.body);
}

void Write(JsonLines& out, const UbxMessage& m) {
  if (const auto* pvt = std::get_if<UbxNavPvt>(&m.body)) {
    out.Number("gps_time_of_week_s", core::ToSeconds(pvt->time_of_week), 3);
    if (pvt->has_date) {
      WriteDate(out, "date", pvt->year, pvt->month, pvt->day);
      const core::Duration time = core::Seconds(pvt->hour * 3600 + pvt->minute * 60 + pvt->second);
      WriteTimeOfDay(out, "time_utc", time);
    }
    out.Unsigned("fix_type", pvt->fix_type);
    out.Boolean("fix_ok", pvt->fix_ok);
    out.Unsigned("carrier", pvt->carrier);
    out.Text("rtk_state", ToString(RtkStateOfPvt(*pvt)));
    out.Unsigned("satellites", pvt->satellites);
    out.Number("lat_deg", pvt->lat_deg, 7);
    out.Number("lon_deg", pvt->lon_deg, 7);
    out.Number("height_ellipsoidal_m", pvt->h_ellipsoidal_m, 3);
    out.Number("altitude_m", pvt->altitude_msl_m, 3);
    out.Number("horizontal_sd_m", pvt->horizontal_sd_m, 3);
    out.Number("vertical_sd_m", pvt->vertical_sd_m, 3);
    Vector(out, "velocity_ned_mps", {pvt->north_mps, pvt->east_mps, pvt->down_mps}, 3);
    out.Number("speed_mps", pvt->ground_speed_mps, 3);
    out.Number("course_deg", pvt->course_deg, 5);
    out.Number("speed_sd_mps", pvt->speed_sd_mps, 3);
    out.Number("pdop", pvt->pdop, 2);
  } else if (const auto* time = std::get_if<UbxNavTimeGps>(&m.body)) {
    out.Number("gps_time_of_week_s", core::ToSeconds(time->time_of_week), 9);
    if (time->week_valid) out.Integer("gps_week", time->week);
    if (time->leap_seconds_valid) out.Integer("leap_seconds", time->gps_minus_utc_s);
  }
}

}  // namespace

void WriteBinary(JsonLines& out, const GnssMessage& message) {
  if (const auto* pbn = message.As<AshtechPbn>()) Write(out, *pbn);
  if (const auto* rtcm3 = message.As<Rtcm3Message>()) Write(out, *rtcm3);
  if (const auto* rtcm2 = message.As<const Rtcm2Message*>()) Write(out, **rtcm2);
  if (const auto* ubx = message.As<UbxMessage>()) Write(out, *ubx);
  out.Unsigned("bytes", message.bytes.empty() ? (*message.As<const Rtcm2Message*>())->stream_bytes
                                              : message.bytes.size());
}

}  // namespace kawara::tools
