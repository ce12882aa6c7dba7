#include "drivers/rtcm2.hpp"

#include "drivers/bit_reader.hpp"

namespace kawara::drivers {
namespace {

constexpr double kCentimetre_m = 0.01;
constexpr double kTenthMillimetre_m = 0.0001;
constexpr double kL1Offset_m = 0.01 / 256.0;
constexpr double kL2Offset_m = 0.01 / 16.0;

unsigned SatelliteId(std::uint64_t five_bits) {
  return five_bits == 0 ? 32U : static_cast<unsigned>(five_bits);
}

/// Forty bits a satellite, running across the word limits; what is left at the end is filling.
bool DecodeCorrections(BitReader& r, bool glonass, Rtcm2Corrections& c) {
  c.glonass = glonass;
  while (r.bits_left() >= 40 && c.count < c.satellites.size()) {
    auto& s = c.satellites[c.count++];
    const bool coarse = r.Flag();
    s.udre = r.As<std::uint8_t>(2);
    s.id = static_cast<std::uint8_t>(SatelliteId(r.Unsigned(5)));
    s.range_m = (coarse ? 0.32 : 0.02) * static_cast<double>(r.Signed(16));
    s.rate_mps = (coarse ? 0.032 : 0.002) * static_cast<double>(r.Signed(8));
    s.issue = r.As<std::uint8_t>(8);
  }
  return r.ok();
}

/// One word of band and time, then two words a satellite: more 1, P code 1, GLONASS 1, satellite 5,
/// the rest.
bool DecodeObservations(BitReader& r, Rtcm2Observations& o) {
  constexpr std::array<std::uint8_t, 4> kBands{1, 0, 2, 0};
  constexpr std::int64_t kMicrosecondLimit = 600'000;  // the header counts in 0.6 s
  o.band = kBands[r.As<std::size_t>(2)];
  r.Skip(2);
  const auto microseconds = r.As<std::int64_t>(20);
  if (microseconds >= kMicrosecondLimit) return false;
  o.time_of_second = std::chrono::microseconds(microseconds);
  while (r.bits_left() >= 48) {
    o.more_follow = r.Flag();
    r.Skip(1);
    const bool glonass = r.Flag();
    const unsigned satellite = SatelliteId(r.Unsigned(5));
    (glonass ? o.glonass_mask : o.gps_mask) |= std::uint32_t{1} << (satellite - 1);
    ++o.count;
    r.Skip(40);
  }
  return r.ok() && r.bits_left() == 0;
}

bool DecodePhaseCentre(BitReader& r, Rtcm2Station& s) {
  for (int axis = 0; axis < 3; ++axis)
    s.ecef_m[axis] = kCentimetre_m * static_cast<double>(r.Signed(32));
  return r.ok();
}

bool DecodeReferencePoint(BitReader& r, Rtcm2Station& s) {
  s.is_reference_point = true;
  for (int axis = 0; axis < 3; ++axis) {
    s.ecef_m[axis] = kTenthMillimetre_m * static_cast<double>(r.Signed(38));
    if (axis < 2) r.Skip(2);
  }
  r.Skip(1);  // GPS or GLONASS
  s.has_antenna_height = r.Flag();
  const auto height = r.Unsigned(18);
  if (s.has_antenna_height) s.antenna_height_m = kTenthMillimetre_m * static_cast<double>(height);
  return r.ok();
}

/// One word, or two with the antenna's height, or three with the offset of L2.
bool DecodeOffset(BitReader& r, Rtcm2StationOffset& o) {
  for (int axis = 0; axis < 3; ++axis)
    o.l1_m[axis] = kL1Offset_m * static_cast<double>(r.Signed(8));
  if (r.bits_left() >= 24) {
    r.Skip(5);
    o.has_antenna_height = !r.Flag();
    const auto height = r.Unsigned(18);
    if (o.has_antenna_height) o.antenna_height_m = kL1Offset_m * static_cast<double>(height);
  }
  if (r.bits_left() >= 24) {
    o.has_l2 = true;
    for (int axis = 0; axis < 3; ++axis)
      o.l2_m[axis] = kL2Offset_m * static_cast<double>(r.Signed(8));
  }
  return r.ok();
}

bool DecodeAntenna(BitReader& r, Rtcm2Antenna& a) {
  r.Skip(2);
  const bool has_serial = r.Flag();
  a.descriptor_length = r.As<std::uint8_t>(5);
  for (std::size_t i = 0; i < a.descriptor_length; ++i) a.descriptor_chars[i] = r.As<char>(8);
  a.setup = r.As<std::uint8_t>(8);
  if (has_serial) {
    r.Skip(3);
    a.serial_length = r.As<std::uint8_t>(5);
    for (std::size_t i = 0; i < a.serial_length; ++i) a.serial_chars[i] = r.As<char>(8);
  }
  return r.ok();
}

}  // namespace

void DecodeRtcm2Body(Rtcm2Message& m) noexcept {
  std::array<std::uint8_t, std::size_t{31} * 3> bytes{};
  for (std::size_t i = 0; i < m.data_words; ++i) {
    for (std::size_t b = 0; b < 3; ++b) {
      bytes[3 * i + b] = static_cast<std::uint8_t>((m.data[i] >> (16 - 8 * b)) & 0xFFU);
    }
  }
  BitReader r(std::span<const std::uint8_t>(bytes).first(std::size_t{3} * m.data_words));
  const auto fill = [&]<class Body>(Body body, auto decode) {
    m.malformed = !decode(body);
    if (!m.malformed) m.body = body;
  };
  m.body = std::monostate{};
  m.malformed = false;
  switch (m.type) {
    case 1:
    case 9:
      return fill(Rtcm2Corrections{}, [&](auto& b) { return DecodeCorrections(r, false, b); });
    case 31:
    case 34:
      return fill(Rtcm2Corrections{}, [&](auto& b) { return DecodeCorrections(r, true, b); });
    case 3:
      return fill(Rtcm2Station{}, [&](auto& b) { return DecodePhaseCentre(r, b); });
    case 18:
    case 19:
    case 20:
    case 21:
      return fill(Rtcm2Observations{}, [&](auto& b) { return DecodeObservations(r, b); });
    case 22:
      return fill(Rtcm2StationOffset{}, [&](auto& b) { return DecodeOffset(r, b); });
    case 23:
      return fill(Rtcm2Antenna{}, [&](auto& b) { return DecodeAntenna(r, b); });
    case 24:
      return fill(Rtcm2Station{}, [&](auto& b) { return DecodeReferencePoint(r, b); });
    default:
      return;
  }
}

core::Duration Rtcm2TimeOfHour(const Rtcm2Message& m) noexcept {
  const auto* observations = std::get_if<Rtcm2Observations>(&m.body);
  return m.time_of_hour +
         (observations != nullptr ? observations->time_of_second : core::Duration(0));
}

}  // namespace kawara::drivers
