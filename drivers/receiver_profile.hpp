#pragma once
#include <cstdint>
#include <string_view>

#include "core/measurements.hpp"
#include "drivers/ashtech.hpp"
#include "drivers/nmea.hpp"
#include "drivers/ubx.hpp"

/// Makers do not agree on what the same field means. What a receiver needs to have said about it
/// beforehand:
namespace kawara::drivers {

enum class ReceiverProfile : std::uint8_t {
  kNmea,           ///< the standard: GGA 1 autonomous, 2 differential, 4 fixed, 5 float
  kAshtechLegacy,  ///< Z-12, Z-Xtreme: GGA 2 = differential OR float, 3 = fixed; fraction of the
                   ///< age = latency; POS in knots and dm/s
  kAshtech,        ///< AC12, ProFlex, SP: GGA as the standard; POS in knots and m/s
};

/// GGA field 6. Where the legacy encoding cannot tell float from code differential the worse one is
/// meant. Source: Z-12 manual p.34 and 48; NMEA 0183.
core::RtkState RtkStateOfGga(std::uint8_t quality, ReceiverProfile profile);
/// $PASHR,POS field 1, the same for all models. Source: Z-Family p.192, SP90M manual p.138.
core::RtkState RtkStateOfPos(int type);
/// $PASHR,CBN flags. Source: Z-Family table 6.61.
core::RtkState RtkStateOfCbn(const AshtechCbn& cbn);

core::RtkState RtkStateOfPvt(const UbxNavPvt& pvt);

/// Height of the antenna above the ellipsoid [m] from a GGA: altitude + separation; the altitude
/// itself where the separation is empty, which is how a Z-12 says that it is ellipsoidal already.
/// NaN without altitude.
double EllipsoidalHeight(const NmeaGga& gga);

struct AgeAndLatency {
  double age_s = kNotSaid;
  double latency_s = kNotSaid;
};
/// The age field of GGA. Legacy: "dd.lll", whole seconds of age and the latency of the solution as
/// fraction.
AgeAndLatency AgeOfGga(const NmeaGga& gga, ReceiverProfile profile);

struct PosVelocity {
  double speed_mps = kNotSaid;
  double up_mps = kNotSaid;
};
PosVelocity VelocityOfPos(const AshtechPos& pos, ReceiverProfile profile);

constexpr double kMpsPerKnot = 1852.0 / 3600.0;

/// "nmea", "ashtech-legacy", "ashtech".
std::string_view ToString(ReceiverProfile profile);
/// False: no such name.
bool FromString(std::string_view name, ReceiverProfile& out);

}  // namespace kawara::drivers
