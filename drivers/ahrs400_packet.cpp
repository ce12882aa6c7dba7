#include "drivers/ahrs400_packet.hpp"

#include <algorithm>

#include "core/geodesy.hpp"

namespace kawara::drivers {
namespace {

constexpr double kStandardGravityMps2 = 9.80665;
constexpr double kInt16Range = 32768.0;
/// Full scale of rates, accelerations and field is 1.5 times the nominal range.
constexpr double kOverRange = 1.5;
constexpr double kMagneticRangeGauss = 1.25;
/// 12-bit converter, 5 V.
constexpr double kVoltsPerCount = 5.0 / 4096.0;

/// Word `i` of the payload, big-endian.
std::uint16_t Word(std::span<const std::uint8_t> frame, std::size_t i) {
  return static_cast<std::uint16_t>((frame[1 + 2 * i] << 8) | frame[2 + 2 * i]);
}

double Signed(std::span<const std::uint8_t> frame, std::size_t i) {
  return static_cast<std::int16_t>(Word(frame, i));
}

Eigen::Vector3d Vector(std::span<const std::uint8_t> frame, std::size_t first, double per_count) {
  return Eigen::Vector3d(Signed(frame, first), Signed(frame, first + 1), Signed(frame, first + 2)) *
         per_count;
}

/// Raw is unsigned (a driver that read it signed was mended later).
double TemperatureDegc(std::uint16_t raw) { return 44.44 * (raw * kVoltsPerCount - 1.375); }

/// Index of the first rate word; the rest follows in the same order in both modes.
constexpr std::size_t FirstRate(Ahrs400Mode mode) { return mode == Ahrs400Mode::kAngle ? 3 : 0; }

}  // namespace

const char* ToString(Ahrs400Mode m) {
  switch (m) {
    case Ahrs400Mode::kAngle:
      return "angle";
    case Ahrs400Mode::kScaled:
      return "scaled";
    case Ahrs400Mode::kVoltage:
      return "voltage";
  }
  return "?";
}

std::uint8_t Ahrs400Checksum(std::span<const std::uint8_t> payload) {
  unsigned sum = 0;
  for (const std::uint8_t byte : payload) sum += byte;
  return static_cast<std::uint8_t>(sum & 0xFFU);
}

bool Ahrs400FrameFits(std::span<const std::uint8_t> frame) {
  return frame.size() > 2 && frame.front() == kAhrs400Header &&
         Ahrs400Checksum(frame.subspan(1, frame.size() - 2)) == frame.back();
}

bool IsAhrs400Version(std::span<const std::uint8_t> frame) {
  if (frame.size() != kAhrs400VersionBytes || !Ahrs400FrameFits(frame)) return false;
  const auto text = frame.subspan(1, frame.size() - 2);
  return std::all_of(text.begin(), text.end(),
                     [](std::uint8_t c) { return c >= 0x20 && c < 0x7F; });
}

core::AhrsSample ScaleAhrs400(std::span<const std::uint8_t> frame, Ahrs400Mode mode,
                              const Ahrs400Scaling& scaling) {
  core::AhrsSample sample;
  if (mode == Ahrs400Mode::kAngle) {
    constexpr double kRadPerCount = core::kPi / kInt16Range;
    sample.has_attitude = true;
    sample.attitude = {Signed(frame, 0) * kRadPerCount, Signed(frame, 1) * kRadPerCount,
                       Signed(frame, 2) * kRadPerCount};
  }
  const std::size_t first = FirstRate(mode);
  const double per_range = kOverRange / kInt16Range;
  sample.rate_radps =
      Vector(frame, first, scaling.rate_range_degps * per_range * core::kRadFromDeg);
  sample.specific_force_mps2 = Vector(
      frame, first + 3,
      scaling.acceleration_sign * scaling.acceleration_range_g * per_range * kStandardGravityMps2);
  sample.magnetic_gauss = Vector(frame, first + 6, kMagneticRangeGauss * per_range);
  sample.temperature_degc = TemperatureDegc(Word(frame, first + 9));
  sample.counter = Ahrs400Counter(frame);
  return sample;
}

Ahrs400Voltages ScaleAhrs400Voltages(std::span<const std::uint8_t> frame) {
  Ahrs400Voltages voltages;
  for (std::size_t i = 0; i < 3; ++i) {
    voltages.gyro_v[i] = Word(frame, i) * kVoltsPerCount;
    voltages.accelerometer_v[i] = Word(frame, 3 + i) * kVoltsPerCount;
    voltages.magnetometer_v[i] = Word(frame, 6 + i) * kVoltsPerCount;
  }
  voltages.temperature_degc = TemperatureDegc(Word(frame, 9));
  voltages.counter = Ahrs400Counter(frame);
  return voltages;
}

std::uint16_t Ahrs400Counter(std::span<const std::uint8_t> frame) {
  return Word(frame, (frame.size() - 2) / 2 - 1);
}

bool IsPlausibleAhrs400(std::span<const std::uint8_t> frame, Ahrs400Mode mode) {
  const double temperature_degc = TemperatureDegc(Word(frame, FirstRate(mode) + 9));
  if (temperature_degc < -55.0 || temperature_degc > 125.0) return false;
  return mode != Ahrs400Mode::kAngle ||
         (Signed(frame, 1) >= -16384.0 && Signed(frame, 1) <= 16384.0);
}

int Ahrs400ModelSuffix(std::string_view version) {
  for (const int suffix : {100, 200}) {
    const std::string_view digits = suffix == 100 ? "-100" : "-200";
    const std::size_t at = version.find(digits);
    if (at == std::string_view::npos) continue;
    const std::size_t after = at + digits.size();
    if (after == version.size() || version[after] < '0' || version[after] > '9') return suffix;
  }
  return 0;
}

}  // namespace kawara::drivers
