#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "vision/panorama_blocks.hpp"

// Tag numbers, types and meanings: CIPA DC-008 (Exif 2.31) tables 4, 7, 8 and 15.
namespace kawara::vision {
namespace {

using Directory = ExifBlock::Directory;
using Rational = ExifBlock::Rational;

enum PrimaryTag : std::uint16_t {
  kMake = 0x010F,
  kModel = 0x0110,
  kOrientation = 0x0112,
  kXResolution = 0x011A,
  kYResolution = 0x011B,
  kResolutionUnit = 0x0128,
  kSoftware = 0x0131,
  kDateTime = 0x0132,
  kYCbCrPositioning = 0x0213,
};
enum ExifTag : std::uint16_t {
  kExifVersion = 0x9000,
  kDateTimeOriginal = 0x9003,
  kDateTimeDigitized = 0x9004,
  kOffsetTime = 0x9010,
  kOffsetTimeOriginal = 0x9011,
  kOffsetTimeDigitized = 0x9012,
  kComponentsConfiguration = 0x9101,
  kUserComment = 0x9286,
  kSubSecTime = 0x9290,
  kSubSecTimeOriginal = 0x9291,
  kSubSecTimeDigitized = 0x9292,
  kFlashpixVersion = 0xA000,
  kColorSpace = 0xA001,
  kPixelXDimension = 0xA002,
  kPixelYDimension = 0xA003,
  kImageUniqueId = 0xA420,
};
enum GpsTag : std::uint16_t {
  kGpsVersionId = 0x00,
  kGpsLatitudeRef = 0x01,
  kGpsLatitude = 0x02,
  kGpsLongitudeRef = 0x03,
  kGpsLongitude = 0x04,
  kGpsAltitudeRef = 0x05,
  kGpsAltitude = 0x06,
  kGpsTimeStamp = 0x07,
  kGpsStatus = 0x09,
  kGpsMeasureMode = 0x0A,
  kGpsDop = 0x0B,
  kGpsImgDirectionRef = 0x10,
  kGpsImgDirection = 0x11,
  kGpsMapDatum = 0x12,
  kGpsDateStamp = 0x1D,
  kGpsDifferential = 0x1E,
  kGpsHPositioningError = 0x1F,
};

constexpr std::uint32_t kArcSecondSteps = 10'000'000;  // 1e-7" is 3 um on the ground
constexpr std::uint32_t kMetreSteps = 10'000;          // 0.1 mm
constexpr std::uint32_t kDegreeSteps = 10'000;
constexpr std::uint32_t kSecondSteps = 10'000'000;  // 59.9999999 s still fits 32 bits

constexpr char kEllipsoidalNote[] =
    "GPSAltitude is the height above the WGS 84 ellipsoid: the geoid separation was not known.";

Rational Steps(double value, std::uint32_t steps) {
  const double scaled = std::clamp(std::round(value * steps), 0.0, 4294967295.0);
  return {static_cast<std::uint32_t>(scaled), steps};
}

std::array<Rational, 3> DegreesMinutesSeconds(double angle_rad) {
  const auto n = static_cast<std::uint64_t>(
      std::llround(std::abs(angle_rad) * core::kDegFromRad * 3600.0 * kArcSecondSteps));
  const std::uint64_t minute = std::uint64_t{60} * kArcSecondSteps;
  return {Rational{static_cast<std::uint32_t>(n / (60 * minute)), 1},
          Rational{static_cast<std::uint32_t>(n / minute % 60), 1},
          Rational{static_cast<std::uint32_t>(n % minute), kArcSecondSteps}};
}

double Value(const Rational& r) {
  return r.second == 0 ? std::nan("") : static_cast<double>(r.first) / r.second;
}

std::string DateText(const core::CivilTime& c, char separator) {
  char text[48];
  std::snprintf(text, sizeof text, "%04d%c%02d%c%02d", c.year, separator, c.month, separator,
                c.day);
  return text;
}

void WriteTime(core::UtcTime time, ExifBlock* exif) {
  const core::CivilTime c = core::ToCivil(time);
  char clock[48];
  std::snprintf(clock, sizeof clock, " %02d:%02d:%02d", c.hour, c.minute, c.second);
  char fraction[16];
  std::snprintf(fraction, sizeof fraction, "%09d", static_cast<int>(c.nanosecond));
  const std::string text = DateText(c, ':') + clock;
  exif->SetAscii(Directory::kPrimary, kDateTime, text);
  exif->SetAscii(Directory::kExif, kDateTimeOriginal, text);
  exif->SetAscii(Directory::kExif, kDateTimeDigitized, text);
  for (std::uint16_t tag : {kOffsetTime, kOffsetTimeOriginal, kOffsetTimeDigitized}) {
    exif->SetAscii(Directory::kExif, tag, "+00:00");
  }
  for (std::uint16_t tag : {kSubSecTime, kSubSecTimeOriginal, kSubSecTimeDigitized}) {
    exif->SetAscii(Directory::kExif, tag, fraction);
  }
  exif->SetAscii(Directory::kGps, kGpsDateStamp, DateText(c, ':'));
  // Cut, not rounded: a time stamp must not reach 60 s.
  const std::uint32_t steps = static_cast<std::uint32_t>(c.second) * kSecondSteps +
                              static_cast<std::uint32_t>(c.nanosecond) / 100;
  const std::array stamp{Rational{static_cast<std::uint32_t>(c.hour), 1},
                         Rational{static_cast<std::uint32_t>(c.minute), 1},
                         Rational{steps, kSecondSteps}};
  exif->SetRationals(Directory::kGps, kGpsTimeStamp, stamp);
}

void WritePosition(const PanoramaMetadata& m, ExifBlock* exif) {
  const core::Geodetic& g = *m.position;
  exif->SetAscii(Directory::kGps, kGpsLatitudeRef, g.lat_rad < 0.0 ? "S" : "N");
  exif->SetRationals(Directory::kGps, kGpsLatitude, DegreesMinutesSeconds(g.lat_rad));
  exif->SetAscii(Directory::kGps, kGpsLongitudeRef, g.lon_rad < 0.0 ? "W" : "E");
  exif->SetRationals(Directory::kGps, kGpsLongitude, DegreesMinutesSeconds(g.lon_rad));
  const bool geoid_known = std::isfinite(m.geoid_separation_m);
  const double altitude_m = g.h_ellipsoidal_m - (geoid_known ? m.geoid_separation_m : 0.0);
  const std::uint8_t below = altitude_m < 0.0 ? 1 : 0;
  exif->SetByte(Directory::kGps, kGpsAltitudeRef, std::span(&below, 1));
  const std::array altitude{Steps(std::abs(altitude_m), kMetreSteps)};
  exif->SetRationals(Directory::kGps, kGpsAltitude, altitude);
  exif->SetAscii(Directory::kGps, kGpsMapDatum, "WGS-84");
  exif->SetAscii(Directory::kGps, kGpsMeasureMode, "3");
  exif->SetAscii(Directory::kGps, kGpsStatus, m.rtk == core::RtkState::kNone ? "V" : "A");
  const bool differential = m.rtk == core::RtkState::kCodeDifferential ||
                            m.rtk == core::RtkState::kFloat || m.rtk == core::RtkState::kFixed;
  exif->SetShort(Directory::kGps, kGpsDifferential, differential ? 1 : 0);
  if (std::isfinite(m.hdop) && m.hdop > 0.0) {
    exif->SetRationals(Directory::kGps, kGpsDop, std::array{Steps(m.hdop, 100)});
  }
  const double horizontal_variance_m2 = m.position_cov_enu_m2(0, 0) + m.position_cov_enu_m2(1, 1);
  if (std::isfinite(horizontal_variance_m2) && horizontal_variance_m2 > 0.0) {
    exif->SetRationals(Directory::kGps, kGpsHPositioningError,
                       std::array{Steps(std::sqrt(horizontal_variance_m2), kMetreSteps)});
  }
  if (!geoid_known) {
    exif->SetUndefined(Directory::kExif, kUserComment,
                       std::string("ASCII\0\0\0", 8) + kEllipsoidalNote);
  }
}

std::optional<double> Angle(const ExifBlock& exif, GpsTag ref_tag, GpsTag tag, char negative) {
  const auto ref = exif.Ascii(Directory::kGps, ref_tag);
  const auto parts = exif.Rationals(Directory::kGps, tag);
  if (!ref || ref->empty() || parts.size() != 3) return {};
  const double degrees = Value(parts[0]) + Value(parts[1]) / 60.0 + Value(parts[2]) / 3600.0;
  if (!std::isfinite(degrees) || degrees > 360.0) return {};
  return (ref->front() == negative ? -degrees : degrees) * core::kRadFromDeg;
}

// Number of exactly `digits` decimal digits at `at`; -1: not there.
int Digits(const std::string& text, std::size_t at, std::size_t digits) {
  int value = 0;
  for (std::size_t i = at; i < at + digits; ++i) {
    if (i >= text.size() || text[i] < '0' || text[i] > '9') return -1;
    value = value * 10 + (text[i] - '0');
  }
  return value;
}

std::optional<core::UtcTime> Checked(const core::CivilTime& c) {
  if (!core::IsValid(c) || c.year < 1970 || c.year > 2200) return {};
  return core::FromCivil(c);
}

std::optional<core::UtcTime> GpsStamp(const ExifBlock& exif) {
  const auto date = exif.Ascii(Directory::kGps, kGpsDateStamp);
  const auto clock = exif.Rationals(Directory::kGps, kGpsTimeStamp);
  if (!date || clock.size() != 3) return {};
  const double hour = Value(clock[0]), minute = Value(clock[1]), second = Value(clock[2]);
  if (!(hour >= 0 && hour < 24 && minute >= 0 && minute < 60 && second >= 0 && second < 61))
    return {};
  const auto midnight = Checked(
      {.year = Digits(*date, 0, 4), .month = Digits(*date, 5, 2), .day = Digits(*date, 8, 2)});
  if (!midnight) return {};
  return *midnight + core::DurationFromSeconds(hour * 3600.0 + minute * 60.0 + second);
}

// Only with its zone: a camera's local time without one is no instant.
std::optional<core::UtcTime> OriginalTime(const ExifBlock& exif) {
  const auto text = exif.Ascii(Directory::kExif, kDateTimeOriginal);
  const auto zone = exif.Ascii(Directory::kExif, kOffsetTimeOriginal);
  if (!text || !zone || zone->size() != 6) return {};
  const auto local = Checked({.year = Digits(*text, 0, 4),
                              .month = Digits(*text, 5, 2),
                              .day = Digits(*text, 8, 2),
                              .hour = Digits(*text, 11, 2),
                              .minute = Digits(*text, 14, 2),
                              .second = Digits(*text, 17, 2)});
  const int zone_hours = Digits(*zone, 1, 2), zone_minutes = Digits(*zone, 4, 2);
  if (!local || zone_hours < 0 || zone_minutes < 0) return {};
  const core::Duration offset = std::chrono::minutes(zone_hours * 60 + zone_minutes);
  core::UtcTime time = zone->front() == '-' ? *local + offset : *local - offset;
  if (const auto fraction = exif.Ascii(Directory::kExif, kSubSecTimeOriginal)) {
    std::int64_t ns = 0, unit = 100'000'000;
    for (char c : *fraction) {
      if (c < '0' || c > '9' || unit == 0) break;
      ns += (c - '0') * unit;
      unit /= 10;
    }
    time += core::Nanoseconds(ns);
  }
  return time;
}

void SetIfGiven(const std::string& text, std::uint16_t tag, ExifBlock* exif) {
  if (!text.empty()) exif->SetAscii(Directory::kPrimary, tag, text);
}

}  // namespace

void WriteExifTags(const PanoramaMetadata& m, int width_px, int height_px, ExifBlock* exif) {
  SetIfGiven(m.make, kMake, exif);
  SetIfGiven(m.model, kModel, exif);
  SetIfGiven(m.software, kSoftware, exif);
  exif->SetShort(Directory::kPrimary, kOrientation, 1);
  if (!exif->Has(Directory::kPrimary, kXResolution)) {
    exif->SetRationals(Directory::kPrimary, kXResolution, std::array{Rational{72, 1}});
    exif->SetRationals(Directory::kPrimary, kYResolution, std::array{Rational{72, 1}});
    exif->SetShort(Directory::kPrimary, kResolutionUnit, 2);
  }
  if (!exif->Has(Directory::kPrimary, kYCbCrPositioning)) {
    exif->SetShort(Directory::kPrimary, kYCbCrPositioning, 1);
  }
  exif->SetUndefined(Directory::kExif, kExifVersion, "0231");  // the first with OffsetTime
  exif->SetUndefined(Directory::kExif, kComponentsConfiguration, std::string_view("\1\2\3\0", 4));
  exif->SetUndefined(Directory::kExif, kFlashpixVersion, "0100");
  exif->SetShort(Directory::kExif, kColorSpace, 1);  // sRGB
  exif->SetLong(Directory::kExif, kPixelXDimension, static_cast<std::uint32_t>(width_px));
  exif->SetLong(Directory::kExif, kPixelYDimension, static_cast<std::uint32_t>(height_px));
  exif->SetAscii(Directory::kExif, kImageUniqueId, ImageUniqueId(m));

  // A new position replaces every old GPS tag: half of one fix and half of another would be a lie.
  if (m.position) exif->Clear(Directory::kGps);
  if (m.position || m.time || m.attitude) {
    constexpr std::uint8_t kVersion[] = {2, 3, 0, 0};
    exif->SetByte(Directory::kGps, kGpsVersionId, kVersion);
  }
  if (m.time) WriteTime(*m.time, exif);
  if (m.position) WritePosition(m, exif);
  if (m.attitude) {
    const double heading_deg = m.attitude->yaw_rad * core::kDegFromRad;
    Rational direction = Steps(heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg, kDegreeSteps);
    direction.first %= 360 * kDegreeSteps;
    exif->SetAscii(Directory::kGps, kGpsImgDirectionRef, "T");
    exif->SetRationals(Directory::kGps, kGpsImgDirection, std::array{direction});
  }
}

void ReadExifTags(const ExifBlock& exif, PanoramaMetadata* m) {
  m->make = exif.Ascii(Directory::kPrimary, kMake).value_or("");
  m->model = exif.Ascii(Directory::kPrimary, kModel).value_or("");
  m->software = exif.Ascii(Directory::kPrimary, kSoftware).value_or("");
  m->time = OriginalTime(exif);
  if (!m->time) m->time = GpsStamp(exif);
  const auto lat = Angle(exif, kGpsLatitudeRef, kGpsLatitude, 'S');
  const auto lon = Angle(exif, kGpsLongitudeRef, kGpsLongitude, 'W');
  if (lat && lon) {
    m->position = core::Geodetic{*lat, *lon, 0.0};
    const auto altitude = exif.Rationals(Directory::kGps, kGpsAltitude);
    if (!altitude.empty() && std::isfinite(Value(altitude[0]))) {
      const bool below = exif.Unsigned(Directory::kGps, kGpsAltitudeRef).value_or(0) == 1;
      m->position->h_ellipsoidal_m = below ? -Value(altitude[0]) : Value(altitude[0]);
    }
  }
  if (const auto dop = exif.Rationals(Directory::kGps, kGpsDop); !dop.empty())
    m->hdop = Value(dop[0]);
  const auto direction = exif.Rationals(Directory::kGps, kGpsImgDirection);
  const bool is_true = exif.Ascii(Directory::kGps, kGpsImgDirectionRef).value_or("") == "T";
  if (is_true && !direction.empty() && std::isfinite(Value(direction[0]))) {
    m->attitude = core::Attitude{0.0, 0.0, core::WrapPi(Value(direction[0]) * core::kRadFromDeg)};
  }
}

}  // namespace kawara::vision
