#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/measurements.hpp"

/// The Crossbow AHRS400's data packets and replies as bytes, and their scale factors: pure
/// functions.
///
/// Sources: layout, checksum and factors agree in four public drivers run on hardware (University
/// of Malaga's xbow4x for the AHRS400CC-100; fdas3 of UFMG and V. Campos' rtai_ahrs for the
/// AHRS400CD-200; ROS ahrs400_driver) and with Crossbow's manual of the sister unit VG700M,
/// 7430-0280-01 rev. F, p. 15-16.
namespace kawara::drivers {

enum class Ahrs400Mode : std::uint8_t {
  kAngle,    ///< attitude, rates, accelerations, magnetic field: 30 bytes, about 60 a second
  kScaled,   ///< the same without attitude: 24 bytes, about 120 a second
  kVoltage,  ///< raw 12-bit counts: 24 bytes, about 160 a second
};
const char* ToString(Ahrs400Mode m);  ///< "angle", "scaled", "voltage"

/// The -100 unit measures up to 100 deg/s and 2 g, the -200 unit up to 200 deg/s and 4 g.
struct Ahrs400Scaling {
  double rate_range_degps = 100.0;
  double acceleration_range_g = 2.0;
  /// +1: accelerations are taken as sent. -1: reversed, for units that send +1 g on z when level
  /// and at rest (drivers disagree; core::AhrsSample wants about -9.8 m/s^2 there).
  double acceleration_sign = 1.0;

  static constexpr Ahrs400Scaling Model100(double sign = 1.0) { return {100.0, 2.0, sign}; }
  static constexpr Ahrs400Scaling Model200(double sign = 1.0) { return {200.0, 4.0, sign}; }
};

constexpr std::uint8_t kAhrs400Header = 0xFF;  ///< occurs inside payloads, too
constexpr std::size_t kAhrs400AnglePacketBytes = 30;
constexpr std::size_t kAhrs400ShortPacketBytes = 24;  ///< scaled and voltage
constexpr std::size_t kAhrs400VersionBytes = 26;
constexpr std::size_t kAhrs400SerialBytes = 6;
constexpr double kAhrs400TickNs = 790.0;  ///< of the down-counter that ends each packet

constexpr std::size_t PacketBytes(Ahrs400Mode m) {
  return m == Ahrs400Mode::kAngle ? kAhrs400AnglePacketBytes : kAhrs400ShortPacketBytes;
}

/// Sum of the bytes modulo 256 (of the payload: header and checksum themselves left out).
std::uint8_t Ahrs400Checksum(std::span<const std::uint8_t> payload);
/// Header, payload and fitting checksum, exactly. Used for packets, version and serial number
/// alike.
bool Ahrs400FrameFits(std::span<const std::uint8_t> frame);
/// A frame whose 24 characters are printable: version replies cannot be mistaken for data.
bool IsAhrs400Version(std::span<const std::uint8_t> frame);

/// Ten 12-bit readings of voltage mode [V]; engineering units need the unit's calibration sheet.
struct Ahrs400Voltages {
  core::MonoTime arrival;
  core::MonoTime sampled;
  std::array<double, 3> gyro_v{};
  std::array<double, 3> accelerometer_v{};
  std::array<double, 3> magnetometer_v{};
  double temperature_degc = 0.0;
  std::uint16_t counter = 0;
};

/// Everything but the stamps. `frame` is a whole packet of `mode` (kAngle or kScaled).
core::AhrsSample ScaleAhrs400(std::span<const std::uint8_t> frame, Ahrs400Mode mode,
                              const Ahrs400Scaling& scaling);
Ahrs400Voltages ScaleAhrs400Voltages(std::span<const std::uint8_t> frame);
/// The counter is the last word of every packet.
std::uint16_t Ahrs400Counter(std::span<const std::uint8_t> frame);
/// Temperature within -55..125 deg C and pitch within +-90 deg: what a packet in step always
/// fulfils and one out of step seldom. Helps the first lock; never refuses a packet whose place is
/// known.
bool IsPlausibleAhrs400(std::span<const std::uint8_t> frame, Ahrs400Mode mode);

/// 100 or 200 from a version text such as "AHRS400CC-100 ..."; 0 if it does not tell.
int Ahrs400ModelSuffix(std::string_view version);

}  // namespace kawara::drivers
