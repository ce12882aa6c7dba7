#include "drivers/receiver_profile.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace kawara::drivers {
namespace {

using core::RtkState;

constexpr double kMpsPerDmps = 0.1;
constexpr std::array<std::pair<std::string_view, ReceiverProfile>, 3> kNames{
    {{"nmea", ReceiverProfile::kNmea},
     {"ashtech-legacy", ReceiverProfile::kAshtechLegacy},
     {"ashtech", ReceiverProfile::kAshtech}}};

}  // namespace

RtkState RtkStateOfGga(std::uint8_t quality, ReceiverProfile profile) {
  if (profile == ReceiverProfile::kAshtechLegacy) {
    switch (quality) {
      case 1:
        return RtkState::kAutonomous;
      case 2:
        return RtkState::kCodeDifferential;
      case 3:
        return RtkState::kFixed;
      default:
        return RtkState::kNone;
    }
  }
  switch (quality) {
    case 1:
    case 3:  // PPS: the military code, no differential
      return RtkState::kAutonomous;
    case 2:
    case 9:  // SBAS, by NovAtel
      return RtkState::kCodeDifferential;
    case 4:
      return RtkState::kFixed;
    case 5:
      return RtkState::kFloat;
    case 6:
      return RtkState::kDeadReckoning;
    default:  // 0 none; 7 typed in by hand and 8 simulated are no measurements
      return RtkState::kNone;
  }
}

RtkState RtkStateOfPos(int type) {
  switch (type) {
    case 0:
      return RtkState::kAutonomous;
    case 1:
    case 9:
    case 10:
      return RtkState::kCodeDifferential;
    case 2:
    case 12:
    case 22:
      return RtkState::kFloat;
    case 3:
    case 13:
    case 23:
      return RtkState::kFixed;
    case 5:
      return RtkState::kDeadReckoning;
    default:
      return RtkState::kNone;
  }
}

RtkState RtkStateOfCbn(const AshtechCbn& cbn) {
  const auto& [a, b, c, d, e, f] = cbn.flags;
  if (a != 1 && a != 2) return RtkState::kNone;
  switch (b) {
    case 0:
      return RtkState::kAutonomous;
    case 1:
      return RtkState::kCodeDifferential;
    case 2:
      return c == 1 ? RtkState::kFixed : RtkState::kFloat;
    default:
      return RtkState::kNone;
  }
}

RtkState RtkStateOfPvt(const UbxNavPvt& pvt) {
  if (!pvt.fix_ok || pvt.fix_type == 0 || pvt.fix_type > 4) return RtkState::kNone;
  if (pvt.fix_type == 1) return RtkState::kDeadReckoning;
  if (pvt.carrier == 2) return RtkState::kFixed;
  if (pvt.carrier == 1) return RtkState::kFloat;
  return pvt.differential ? RtkState::kCodeDifferential : RtkState::kAutonomous;
}

double EllipsoidalHeight(const NmeaGga& gga) {
  return std::isnan(gga.geoid_separation_m) ? gga.altitude_m
                                            : gga.altitude_m + gga.geoid_separation_m;
}

AgeAndLatency AgeOfGga(const NmeaGga& gga, ReceiverProfile profile) {
  if (profile != ReceiverProfile::kAshtechLegacy || std::isnan(gga.age_s))
    return {gga.age_s, kNotSaid};
  const double whole = std::floor(gga.age_s);
  return {whole, gga.age_s - whole};
}

PosVelocity VelocityOfPos(const AshtechPos& pos, ReceiverProfile profile) {
  const double up_unit = profile == ReceiverProfile::kAshtechLegacy ? kMpsPerDmps : 1.0;
  return {pos.speed_as_sent * kMpsPerKnot, pos.vertical_as_sent * up_unit};
}

std::string_view ToString(ReceiverProfile profile) {
  for (const auto& [name, value] : kNames) {
    if (value == profile) return name;
  }
  return "nmea";
}

bool FromString(std::string_view name, ReceiverProfile& out) {
  for (const auto& [known, value] : kNames) {
    if (known == name) {
      out = value;
      return true;
    }
  }
  return false;
}

}  // namespace kawara::drivers
