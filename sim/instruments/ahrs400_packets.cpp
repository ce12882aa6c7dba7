#include "sim/instruments/ahrs400_packets.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::sim {
namespace {

constexpr std::uint8_t kHeader = 0xFF;
constexpr double kGravity_mps2 = 9.80665;
constexpr double kMagneticFullScale_gauss = 1.25 * 1.5;
constexpr std::size_t kVersionCharacters = 24;

void PutWord(std::vector<std::uint8_t>& out, std::uint16_t word) {
  out.push_back(static_cast<std::uint8_t>(word >> 8));
  out.push_back(static_cast<std::uint8_t>(word & 0xFFU));
}

void Close(std::vector<std::uint8_t>& packet) {
  unsigned sum = 0;
  for (std::size_t i = 1; i < packet.size(); ++i) sum += packet[i];
  packet.push_back(static_cast<std::uint8_t>(sum & 0xFFU));
}

}  // namespace

std::uint16_t Ahrs400Encoder::Signed(double value, double full_scale) {
  const double scaled = std::round(value / full_scale * 32768.0);
  const double limited = std::clamp(scaled, -32768.0, 32767.0);
  if (limited != scaled) ++saturated_;
  return static_cast<std::uint16_t>(static_cast<std::int16_t>(limited));
}

std::uint16_t Ahrs400Encoder::Count12(double value, double full_scale) {
  const double scaled = std::round(2048.0 + value / full_scale * 2048.0);
  const double limited = std::clamp(scaled, 0.0, 4095.0);
  if (limited != scaled) ++saturated_;
  return static_cast<std::uint16_t>(limited);
}

std::vector<std::uint8_t> Ahrs400Encoder::Packet(Ahrs400Output output, const AhrsState& state,
                                                 double temperature_degc, std::uint16_t counter) {
  const double rate_scale = ranges_.rate_degps * 1.5;
  const double force_scale = ranges_.force_g * 1.5;
  const Eigen::Vector3d rate_degps = state.rate_radps * core::kDegFromRad;
  const Eigen::Vector3d force_g = state.specific_force_mps2 * (ranges_.force_sign / kGravity_mps2);
  const auto word = [&](double value, double full_scale) {
    return output == Ahrs400Output::kVoltage ? Count12(value, full_scale)
                                             : Signed(value, full_scale);
  };
  std::vector<std::uint8_t> packet{kHeader};
  if (output == Ahrs400Output::kAngle) {
    const core::Attitude& a = state.attitude;
    for (const double angle_rad : {a.roll_rad, a.pitch_rad, a.yaw_rad}) {
      // 180 degrees is the same as -180: wraps, is no saturation.
      const double angle_deg = angle_rad * core::kDegFromRad;
      PutWord(packet,
              Signed(angle_deg >= 180.0 - 180.0 / 65536.0 ? angle_deg - 360.0 : angle_deg, 180.0));
    }
  }
  for (const double v : rate_degps) PutWord(packet, word(v, rate_scale));
  for (const double v : force_g) PutWord(packet, word(v, force_scale));
  for (const double v : state.magnetic_gauss) PutWord(packet, word(v, kMagneticFullScale_gauss));
  const double temperature =
      std::clamp((temperature_degc / 44.44 + 1.375) * 4096.0 / 5.0, 0.0, 4095.0);
  PutWord(packet, static_cast<std::uint16_t>(std::lround(temperature)));
  PutWord(packet, counter);
  Close(packet);
  return packet;
}

std::vector<std::uint8_t> Ahrs400Encoder::Version(std::string_view text) {
  std::vector<std::uint8_t> reply{kHeader};
  for (std::size_t i = 0; i < kVersionCharacters; ++i) {
    reply.push_back(static_cast<std::uint8_t>(i < text.size() ? text[i] : ' '));
  }
  Close(reply);
  return reply;
}

std::vector<std::uint8_t> Ahrs400Encoder::SerialNumber(std::uint32_t number) {
  std::vector<std::uint8_t> reply{kHeader};
  PutWord(reply, static_cast<std::uint16_t>(number >> 16));
  PutWord(reply, static_cast<std::uint16_t>(number & 0xFFFFU));
  Close(reply);
  return reply;
}

}  // namespace kawara::sim
