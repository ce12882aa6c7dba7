#include "sim/instruments/gps_sentences.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>

#include "sim/instruments/ashtech_settings.hpp"

namespace kawara::sim {
namespace {

constexpr double kKnotsPerMps = 3600.0 / 1852.0;

__attribute__((format(printf, 1, 2))) std::string Format(const char* format, ...) {
  std::array<char, 256> text{};
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

std::string UtcField(core::GpsTime t) {
  const core::CivilTime c = core::ToCivil(core::ToUtc(t));
  const int ms = c.nanosecond / 1000000;
  const std::string clock = Format("%02d%02d%02d.", c.hour, c.minute, c.second);
  return clock + (ms % 10 == 0 ? Format("%02d", ms / 10) : Format("%03d", ms));
}

/// "4005.7976080,N" (degrees in `digits` places). Integers, so that 59.99999995' never prints as
/// 60'.
std::string AngleField(double angle_rad, int digits, char positive, char negative) {
  constexpr std::int64_t kUnitsPerMinute = 10000000;
  constexpr std::int64_t kUnitsPerDegree = 60 * kUnitsPerMinute;
  const std::int64_t units =
      std::llround(std::abs(angle_rad) * core::kDegFromRad * static_cast<double>(kUnitsPerDegree));
  return Format("%0*lld%02lld.%07lld,%c", digits, static_cast<long long>(units / kUnitsPerDegree),
                static_cast<long long>(units % kUnitsPerDegree / kUnitsPerMinute),
                static_cast<long long>(units % kUnitsPerMinute),
                angle_rad < 0.0 ? negative : positive);
}
std::string LatLonFields(const core::Geodetic& g) {
  return AngleField(g.lat_rad, 2, 'N', 'S') + "," + AngleField(g.lon_rad, 3, 'E', 'W');
}

double Speed(const GpsSolution& s) { return s.velocity_ned_mps.head<2>().norm(); }
double CourseDeg(const GpsSolution& s) {
  const double course =
      std::atan2(s.velocity_ned_mps.y(), s.velocity_ned_mps.x()) * core::kDegFromRad;
  return course < 0.0 ? course + 360.0 : course;
}

int GgaCode(core::RtkState rtk, GgaQuality encoding) {
  const bool legacy = encoding == GgaQuality::kAshtechLegacy;
  switch (rtk) {
    case core::RtkState::kAutonomous:
      return 1;
    case core::RtkState::kCodeDifferential:
      return 2;
    case core::RtkState::kFloat:
      return legacy ? 2 : 5;
    case core::RtkState::kFixed:
      return legacy ? 3 : 4;
    default:
      return 0;
  }
}
char ModeLetter(core::RtkState rtk) {
  switch (rtk) {
    case core::RtkState::kAutonomous:
      return 'A';
    case core::RtkState::kCodeDifferential:
      return 'D';
    case core::RtkState::kFloat:
      return 'F';
    case core::RtkState::kFixed:
      return 'R';
    default:
      return 'N';
  }
}
/// POS field 1, and the B of CBN's flags up to 2.
int PosCode(core::RtkState rtk) {
  return static_cast<int>(rtk) - static_cast<int>(core::RtkState::kAutonomous);
}

/// The old family prints whole seconds of age and, as fraction, the latency of the solution in
/// milliseconds.
std::string AgeField(const GpsSolution& s, GgaQuality encoding) {
  if (!s.correction_age_s) return {};
  if (encoding == GgaQuality::kNmea23) return Format("%.1f", *s.correction_age_s);
  return Format("%02d.%03d", static_cast<int>(std::min(*s.correction_age_s, 99.0)),
                s.latency_ms % 1000);
}

std::string WeekdayClock(const char* name, core::GpsTime t) {
  constexpr std::int64_t kTick_ns = 100;
  const core::GpsTime rounded =
      core::GpsTime::FromNs((t.ns() + kTick_ns / 2) / kTick_ns * kTick_ns);
  const std::int64_t of_week = core::ToWeek(rounded).time_of_week.count();
  const std::int64_t of_day = of_week % core::kDay.count();
  const std::int64_t second = of_day / 1000000000;
  return WithChecksum(Format(
      "PASHR,%s,%lld,%02lld:%02lld:%02lld.%07lld", name,
      static_cast<long long>(of_week / core::kDay.count() + 1),
      static_cast<long long>(second / 3600), static_cast<long long>(second / 60 % 60),
      static_cast<long long>(second % 60), static_cast<long long>(of_day % 1000000000 / kTick_ns)));
}

}  // namespace

std::string GgaSentence(const GpsSolution& s, GgaQuality encoding) {
  if (s.rtk == core::RtkState::kNone) {
    return WithChecksum("GPGGA," + UtcField(s.time) + ",,,,,0," + Format("%02d", s.satellites) +
                        ",,,M,,M,,");
  }
  return WithChecksum("GPGGA," + UtcField(s.time) + "," + LatLonFields(s.antenna) +
                      Format(",%d,%02d,%.1f,%.4f,M,%.4f,M,", GgaCode(s.rtk, encoding), s.satellites,
                             s.hdop, s.antenna.h_ellipsoidal_m - s.geoid_m, s.geoid_m) +
                      AgeField(s, encoding) + ",");
}

std::string RmcSentence(const GpsSolution& s) {
  const core::CivilTime c = core::ToCivil(core::ToUtc(s.time));
  const std::string date = Format("%02d%02d%02d", c.day, c.month, c.year % 100);
  if (s.rtk == core::RtkState::kNone)
    return WithChecksum("GPRMC," + UtcField(s.time) + ",V,,,,,,," + date + ",,,N");
  return WithChecksum("GPRMC," + UtcField(s.time) + ",A," + LatLonFields(s.antenna) +
                      Format(",%.3f,%.2f,", Speed(s) * kKnotsPerMps, CourseDeg(s)) + date +
                      Format(",,,%c", ModeLetter(s.rtk)));
}

std::string VtgSentence(const GpsSolution& s) {
  if (s.rtk == core::RtkState::kNone) return {};
  return WithChecksum(Format("GPVTG,%.2f,T,,M,%.3f,N,%.3f,K,%c", CourseDeg(s),
                             Speed(s) * kKnotsPerMps, Speed(s) * 3.6, ModeLetter(s.rtk)));
}

std::string GstSentence(const GpsSolution& s) {
  if (s.rtk == core::RtkState::kNone) return {};
  const double north = s.sd_ned_m.x();
  const double east = s.sd_ned_m.y();
  // The recorded errors are uncorrelated: the ellipse lies along the axes, north when they are
  // equal.
  const bool along_east = east > north;
  return WithChecksum("GPGST," + UtcField(s.time) +
                      Format(",%.4f,%.4f,%.4f,%.1f,%.4f,%.4f,%.4f", s.sd_ned_m.norm(),
                             along_east ? east : north, along_east ? north : east,
                             along_east ? 90.0 : 0.0, north, east, s.sd_ned_m.z()));
}

std::string GsaSentence(const GpsSolution& s) {
  if (s.rtk == core::RtkState::kNone) return WithChecksum("GPGSA,A,1,,,,,,,,,,,,,,,");
  return WithChecksum(Format("GPGSA,A,3,,,,,,,,,,,,,%.1f,%.1f,%.1f", s.pdop, s.hdop, s.vdop));
}

std::string ZdaSentence(const GpsSolution& s) {
  const core::CivilTime c = core::ToCivil(core::ToUtc(s.time));
  return WithChecksum("GPZDA," + UtcField(s.time) +
                      Format(",%02d,%02d,%04d,00,00", c.day, c.month, c.year));
}

std::string PosSentence(const GpsSolution& s) {
  if (s.rtk == core::RtkState::kNone) {
    return WithChecksum(Format("PASHR,POS,,%02d,", s.satellites) + UtcField(s.time) +
                        ",,,,,,,,,,,,,,SIM0");
  }
  return WithChecksum(Format("PASHR,POS,%d,%02d,", PosCode(s.rtk), s.satellites) +
                      UtcField(s.time) + "," + LatLonFields(s.antenna) +
                      Format(",%+011.4f,,%05.1f,%05.1f,%+06.1f,%04.1f,%04.1f,%04.1f,%04.1f,SIM0",
                             s.antenna.h_ellipsoidal_m, CourseDeg(s), Speed(s) * kKnotsPerMps,
                             -s.velocity_ned_mps.z() * 10.0, s.pdop, s.hdop, s.vdop, s.tdop));
}

std::string CbnSentence(const GpsSolution& s) {
  if (s.rtk == core::RtkState::kNone) return {};
  const int pos = PosCode(s.rtk);
  const bool rtk = pos >= 2;
  const Eigen::Vector3d& v = s.velocity_ned_mps;
  const Eigen::Vector3d& sv = s.velocity_sd_ned_mps;
  return WithChecksum(
      "PASHR,CBN," + UtcField(s.time) + Format(",SIM_,%02d,%.1f,", s.satellites, s.pdop) +
      LatLonFields(s.antenna) +
      Format(",%+.4f,%.4f,%.4f,%.4f,%+.4f,%+.4f,%+.4f,", s.antenna.h_ellipsoidal_m, s.sd_ned_m.x(),
             s.sd_ned_m.y(), s.sd_ned_m.z(), 0.0, 0.0, 0.0) +
      // A 3D, B kind, C integers fixed, D projected in time, E spare, F fast CPD.
      Format("2%d%d%d0%d,", rtk ? 2 : pos, pos == 3 ? 1 : 0, rtk && s.fast_cpd ? 1 : 0,
             rtk && s.fast_cpd ? 1 : 0) +
      Format("%+.3f,%+.3f,%+.3f,%.3f,%.3f,%.3f", v.y(), v.x(), -v.z(), sv.y(), sv.x(), sv.z()));
}

std::string LtnSentence(const GpsSolution& s) {
  return WithChecksum(Format("PASHR,LTN,%d", s.latency_ms));
}

std::string PttSentence(core::GpsTime pulse) { return WeekdayClock("PTT", pulse); }
std::string TttSentence(core::GpsTime event) { return WeekdayClock("TTT", event); }

}  // namespace kawara::sim
