#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "sim/motion/ahrs_trace.hpp"

namespace kawara::sim {

enum class Ahrs400Output : std::uint8_t { kAngle, kScaled, kVoltage };

/// Ranges of the two models, and what is a matter of the unit's software.
struct Ahrs400Ranges {
  double rate_degps = 100.0;  ///< -100 model; -200: 200
  double force_g = 2.0;       ///< -100 model; -200: 4
  double force_sign = 1.0;    ///< -1: accelerations with the opposite sign of the specific force
};

/// Builds what an AHRS400 sends; independent of drivers/, so that a common error cannot hide.
/// Big-endian 16-bit words; header 0xFF; checksum the sum of the payload. Full scale is 1.5 times
/// the range (magnetic: 1.25 gauss times 1.5), angles 180 degrees, each as 2^15; temperature 44.44
/// (raw 5/4096 - 1.375) deg C; time a down-counter of 0.79 us. Sources: Crossbow VG700M manual
/// 7430-0280-01 (same protocol family); public drivers of the AHRS400CC-100 and CD-200 agree.
/// Voltage counts need a calibration sheet on real units; here 12 bits span the full scale, 2048 is
/// zero.
class Ahrs400Encoder {
 public:
  explicit Ahrs400Encoder(const Ahrs400Ranges& ranges) : ranges_(ranges) {}

  std::vector<std::uint8_t> Packet(Ahrs400Output output, const AhrsState& state,
                                   double temperature_degc, std::uint16_t counter);
  /// Values that met the end of their range, since the start.
  std::uint64_t saturated() const { return saturated_; }

  /// 0xFF, 24 characters (padded with blanks), checksum.
  static std::vector<std::uint8_t> Version(std::string_view text);
  /// 0xFF, four bytes, checksum.
  static std::vector<std::uint8_t> SerialNumber(std::uint32_t number);

 private:
  std::uint16_t Signed(double value, double full_scale);
  std::uint16_t Count12(double value, double full_scale);
  Ahrs400Ranges ranges_;
  std::uint64_t saturated_ = 0;
};

}  // namespace kawara::sim
