#include "drivers/rtcm3.hpp"

#include <bit>
#include <limits>

#include "drivers/bit_reader.hpp"

namespace kawara::drivers {
namespace {

constexpr double kEcefResolution_m = 0.0001;
constexpr double kBiasResolution_m = 0.02;
constexpr core::Duration kGlonassDay = core::kDay;
constexpr core::Duration kGlonassMinusUtc = std::chrono::hours(3);
constexpr core::Duration kGpsMinusBeidou = std::chrono::seconds(14);

/// Satellite block and signal block [bits per satellite, bits per cell] of MSM1..7, RTCM 10403
/// tables 3.5-79 ff.
struct MsmSizes {
  unsigned satellite;
  unsigned cell;
};
constexpr std::array<MsmSizes, 8> kMsmSizes{
    {{0, 0}, {10, 15}, {10, 27}, {10, 42}, {18, 48}, {36, 63}, {18, 65}, {36, 80}}};

std::string_view TextAt(std::span<const std::uint8_t> payload, std::size_t byte,
                        std::size_t count) {
  return {reinterpret_cast<const char*>(payload.data()) + byte, count};
}

/// 8-bit length, then that many characters; every such field of 1007, 1008, 1033 lies on a byte
/// boundary.
std::string_view CountedText(BitReader& r, std::span<const std::uint8_t> payload) {
  const auto count = r.As<std::size_t>(8);
  const std::size_t at = r.position() / 8;
  r.Skip(count * 8);
  return r.ok() ? TextAt(payload, at, count) : std::string_view();
}

/// 1001-1004 (GPS) and 1009-1012 (GLONASS): a short header, then one block per satellite.
bool DecodeLegacyObservations(unsigned type, BitReader& r, Rtcm3Observations& o) {
  const bool glonass = type >= 1009;
  const unsigned form =
      glonass ? type - 1009 : type - 1001;  // 0, 1: L1 only; 2, 3: L1 and L2; odd: extended
  const bool two_bands = form >= 2;
  o.system = glonass ? GnssSystem::kGlonass : GnssSystem::kGps;
  o.time_sent = std::chrono::milliseconds(r.As<std::int64_t>(glonass ? 27 : 30));
  o.more_follow = r.Flag();
  o.satellites = r.As<std::uint8_t>(5);
  r.Skip(1 + 3);  // smoothing
  o.signals = two_bands ? 2 : 1;
  // Blocks begin alike: satellite 6, code 1, [GLONASS: frequency channel 5], L1 pseudorange 24 or
  // 25, phase 20, lock 7, [extended: ambiguity 8 or 7, C/N0 8], then L2: code 2, pseudorange
  // difference 14, ...
  const unsigned l1_rest = 1 + (glonass ? 5 + 25 : 24) + 20 + 7;
  const unsigned l1_extension = (form % 2 != 0) ? (glonass ? 7U : 8U) + 8U : 0U;
  constexpr std::int64_t kNoL2Range = -8192;  // DF017, DF047: 0x2000 = L2 pseudorange invalid
  for (unsigned s = 0; s < o.satellites; ++s) {
    const auto id = r.As<unsigned>(6);
    if (id > 0) o.satellite_mask |= std::uint64_t{1} << (id - 1);
    r.Skip(l1_rest + l1_extension);
    ++o.observations;
    if (!two_bands) continue;
    r.Skip(2);
    if (r.Signed(14) != kNoL2Range) ++o.observations;
    r.Skip(20 + 7 + ((form % 2 != 0) ? 8U : 0U));
  }
  return r.ok();
}

bool DecodeMsm(unsigned type, BitReader& r, Rtcm3Observations& o) {
  constexpr std::array<GnssSystem, 7> kSystems{
      GnssSystem::kGps,  GnssSystem::kGlonass, GnssSystem::kGalileo, GnssSystem::kSbas,
      GnssSystem::kQzss, GnssSystem::kBeidou,  GnssSystem::kNavic};
  o.system = kSystems[(type - 1071) / 10];
  o.msm = static_cast<std::uint8_t>((type - 1070) % 10);
  if (o.system == GnssSystem::kGlonass) {
    constexpr unsigned kDayUnknown = 7;
    const auto day = r.As<unsigned>(3);
    if (day != kDayUnknown) o.glonass_day_of_week = static_cast<std::int8_t>(day);
    o.time_sent = std::chrono::milliseconds(r.As<std::int64_t>(27));
  } else {
    o.time_sent = std::chrono::milliseconds(r.As<std::int64_t>(30));
  }
  o.more_follow = r.Flag();
  r.Skip(3 + 7 + 2 + 2 + 1 + 3);  // issue of station, reserved, steering, external clock, smoothing
  const std::uint64_t satellites_first_is_top = r.Unsigned(64);
  for (unsigned i = 0; i < 64; ++i) {
    if (((satellites_first_is_top >> (63 - i)) & 1U) != 0)
      o.satellite_mask |= std::uint64_t{1} << i;
  }
  const auto satellites = static_cast<unsigned>(std::popcount(satellites_first_is_top));
  const auto signals = static_cast<unsigned>(std::popcount(r.As<std::uint32_t>(32)));
  const unsigned cells_possible = satellites * signals;
  if (cells_possible > 64)
    return false;  // not allowed by the standard: the cell mask would not fit
  const auto cells = static_cast<unsigned>(std::popcount(r.Unsigned(cells_possible)));
  o.satellites = static_cast<std::uint8_t>(satellites);
  o.signals = static_cast<std::uint8_t>(signals);
  o.observations = static_cast<std::uint16_t>(cells);
  const MsmSizes sizes = kMsmSizes[o.msm];
  r.Skip(std::size_t{sizes.satellite} * satellites + std::size_t{sizes.cell} * cells);
  return r.ok();
}

bool DecodeStation(bool with_height, BitReader& r, Rtcm3Station& s) {
  s.itrf_year = r.As<std::uint8_t>(6);
  s.gps = r.Flag();
  s.glonass = r.Flag();
  s.galileo = r.Flag();
  s.virtual_station = r.Flag();
  const auto x = r.Signed(38);
  r.Skip(2);
  const auto y = r.Signed(38);
  r.Skip(2);
  const auto z = r.Signed(38);
  s.ecef_m = kEcefResolution_m * Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y),
                                                 static_cast<double>(z));
  s.has_antenna_height = with_height;
  if (with_height) s.antenna_height_m = kEcefResolution_m * static_cast<double>(r.Unsigned(16));
  return r.ok();
}

bool DecodeDescriptor(unsigned type, BitReader& r, std::span<const std::uint8_t> payload,
                      Rtcm3Descriptor& d) {
  d.antenna = CountedText(r, payload);
  d.antenna_setup = r.As<std::uint8_t>(8);
  if (type >= 1008) d.antenna_serial = CountedText(r, payload);
  if (type == 1033) {
    d.receiver = CountedText(r, payload);
    d.receiver_firmware = CountedText(r, payload);
    d.receiver_serial = CountedText(r, payload);
  }
  return r.ok();
}

bool DecodeGlonassBiases(BitReader& r, Rtcm3GlonassBiases& b) {
  b.aligned = r.Flag();
  r.Skip(3);
  const auto mask = r.As<unsigned>(4);
  for (std::size_t i = 0; i < b.bias_m.size(); ++i) {
    const bool sent = ((mask >> (3 - i)) & 1U) != 0;
    b.bias_m[i] = sent ? kBiasResolution_m * static_cast<double>(r.Signed(16))
                       : std::numeric_limits<double>::quiet_NaN();
  }
  return r.ok();
}

struct EphemerisForm {
  unsigned type;
  GnssSystem system;
  unsigned satellite_bits;
  std::size_t bits;  ///< whole message
};
constexpr std::array<EphemerisForm, 6> kEphemerides{{{1019, GnssSystem::kGps, 6, 488},
                                                     {1020, GnssSystem::kGlonass, 6, 360},
                                                     {1042, GnssSystem::kBeidou, 6, 511},
                                                     {1044, GnssSystem::kQzss, 4, 485},
                                                     {1045, GnssSystem::kGalileo, 6, 496},
                                                     {1046, GnssSystem::kGalileo, 6, 504}}};

bool DecodeSystemParameters(BitReader& r, Rtcm3SystemParameters& p) {
  p.modified_julian_day = r.As<std::uint16_t>(16);
  p.second_of_day = r.As<std::uint32_t>(17);
  p.announced = r.As<std::uint8_t>(5);
  p.leap_seconds = r.As<std::uint8_t>(8);
  for (std::size_t i = 0; i < p.announced; ++i) {
    auto& a = p.announcements[i];
    a.type = r.As<std::uint16_t>(12);
    a.synchronous = r.Flag();
    a.interval_s = 0.1 * static_cast<double>(r.Unsigned(16));
  }
  return r.ok();
}

bool DecodeText(BitReader& r, std::span<const std::uint8_t> payload, Rtcm3Text& t) {
  t.modified_julian_day = r.As<std::uint16_t>(16);
  t.second_of_day = r.As<std::uint32_t>(17);
  t.characters = r.As<std::uint8_t>(7);
  t.utf8 = CountedText(r, payload);
  return r.ok();
}

bool IsLegacyObservations(unsigned type) {
  return (type >= 1001 && type <= 1004) || (type >= 1009 && type <= 1012);
}
bool IsMsm(unsigned type) {
  const unsigned form = type % 10;
  return type >= 1071 && type <= 1137 && form >= 1 && form <= 7;
}

}  // namespace

const char* ToString(GnssSystem s) {
  switch (s) {
    case GnssSystem::kGps:
      return "GPS";
    case GnssSystem::kGlonass:
      return "GLONASS";
    case GnssSystem::kGalileo:
      return "Galileo";
    case GnssSystem::kSbas:
      return "SBAS";
    case GnssSystem::kQzss:
      return "QZSS";
    case GnssSystem::kBeidou:
      return "BeiDou";
    case GnssSystem::kNavic:
      return "NavIC";
  }
  return "?";
}

Rtcm3Message DecodeRtcm3(std::span<const std::uint8_t> payload) noexcept {
  Rtcm3Message m;
  m.length = static_cast<std::uint16_t>(payload.size());
  BitReader r(payload);
  m.type = r.As<std::uint16_t>(12);
  if (!r.ok()) return m;
  const unsigned type = m.type;

  for (const EphemerisForm& form : kEphemerides) {
    if (type != form.type) continue;
    const Rtcm3Ephemeris e{form.system, r.As<std::uint8_t>(form.satellite_bits)};
    m.malformed = payload.size() * 8 < form.bits;
    if (!m.malformed) m.body = e;
    return m;
  }

  // Everything else that we look into continues with the station's number.
  const auto fill = [&]<class Body>(Body, auto decode) {
    m.station = r.As<std::uint16_t>(12);
    m.has_station = r.ok();
    Body body;
    m.malformed = !decode(body) || !r.ok();
    if (!m.malformed) m.body = body;
  };
  if (IsLegacyObservations(type)) {
    fill(Rtcm3Observations{}, [&](auto& body) { return DecodeLegacyObservations(type, r, body); });
  } else if (IsMsm(type)) {
    fill(Rtcm3Observations{}, [&](auto& body) { return DecodeMsm(type, r, body); });
  } else if (type == 1005 || type == 1006) {
    fill(Rtcm3Station{}, [&](auto& body) { return DecodeStation(type == 1006, r, body); });
  } else if (type == 1007 || type == 1008 || type == 1033) {
    fill(Rtcm3Descriptor{}, [&](auto& body) { return DecodeDescriptor(type, r, payload, body); });
  } else if (type == 1230) {
    fill(Rtcm3GlonassBiases{}, [&](auto& body) { return DecodeGlonassBiases(r, body); });
  } else if (type == 1013) {
    fill(Rtcm3SystemParameters{}, [&](auto& body) { return DecodeSystemParameters(r, body); });
  } else if (type == 1029) {
    fill(Rtcm3Text{}, [&](auto& body) { return DecodeText(r, payload, body); });
  }
  return m;
}

std::optional<core::GpsTime> EpochOf(const Rtcm3Observations& o, core::GpsTime reference,
                                     const core::LeapSeconds& leaps) {
  if (o.system != GnssSystem::kGlonass) {
    if (o.time_sent >= core::kGpsWeek) return std::nullopt;
    const core::Duration shift =
        o.system == GnssSystem::kBeidou ? kGpsMinusBeidou : core::Duration(0);
    return core::ResolveTimeOfWeek((o.time_sent + shift) % core::kGpsWeek, reference);
  }
  if (o.time_sent >= kGlonassDay) return std::nullopt;
  const core::Duration utc_of_day = (o.time_sent + core::kDay - kGlonassMinusUtc) % core::kDay;
  return core::ToGps(core::ResolveTimeOfDay(utc_of_day, core::ToUtc(reference, leaps)), leaps);
}

}  // namespace kawara::drivers
