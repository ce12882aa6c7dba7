#pragma once
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

/// AHRS400 bytes made for tests from the published layout, without the code under test.
namespace kawara::drivers::testing {

using Bytes = std::vector<std::uint8_t>;

inline Bytes Frame(const Bytes& payload) {
  Bytes frame{0xFF};
  unsigned sum = 0;
  for (const std::uint8_t b : payload) {
    frame.push_back(b);
    sum += b;
  }
  frame.push_back(static_cast<std::uint8_t>(sum % 256));
  return frame;
}

inline Bytes Packet(const std::vector<std::uint16_t>& words) {
  Bytes payload;
  for (const std::uint16_t w : words) {
    payload.push_back(static_cast<std::uint8_t>(w / 256));
    payload.push_back(static_cast<std::uint8_t>(w % 256));
  }
  return Frame(payload);
}

inline Bytes Version(std::string_view text) {
  Bytes payload(24, ' ');
  for (std::size_t i = 0; i < text.size() && i < 24; ++i)
    payload[i] = static_cast<std::uint8_t>(text[i]);
  return Frame(payload);
}

inline void Append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

/// A unit that moves a little: small values of both signs, so 0xFF and 0x00 are frequent in the
/// payload.
class Unit {
 public:
  explicit Unit(std::uint32_t seed) : random_(seed) {}

  std::uint16_t counter() const { return counter_; }
  Bytes Angle() { return Make(14); }
  Bytes Scaled() { return Make(11); }
  Bytes Garbage(std::size_t n) {
    Bytes bytes(n);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random_());
    return bytes;
  }
  /// `period_ticks` of the down-counter pass between packets: 16.7 ms are 21097.
  std::uint16_t period_ticks = 21097;

 private:
  Bytes Make(std::size_t words) {
    std::normal_distribution<double> small(0.0, 200.0);
    std::vector<std::uint16_t> w(words);
    for (auto& v : w) v = static_cast<std::uint16_t>(static_cast<std::int16_t>(small(random_)));
    w[words - 3] = static_cast<std::uint16_t>(1500 + random_() % 8);  // mag z, harmless
    w[words - 2] = static_cast<std::uint16_t>(1500 + random_() % 8);  // temperature: 20 deg C
    counter_ = static_cast<std::uint16_t>(counter_ - period_ticks);
    w[words - 1] = counter_;
    return Packet(w);
  }

  std::mt19937 random_;
  std::uint16_t counter_ = 777;
};

}  // namespace kawara::drivers::testing
