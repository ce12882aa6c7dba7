#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "core/time.hpp"

/// RTCM SC-104 2.x, the only corrections a Z-Family receiver takes. This is what a message says;
/// Rtcm2Decoder finds messages in bytes. Source: RTCM 10402.3 message layouts, cross-checked
/// against two independent decoders.
namespace kawara::drivers {

/// 1, 9 GPS and 31, 34 GLONASS pseudorange corrections.
struct Rtcm2Corrections {
  bool glonass = false;
  std::uint8_t count = 0;
  struct Satellite {
    std::uint8_t id = 0;    ///< 1..32
    std::uint8_t udre = 0;  ///< 0..3, a class of expected range error
    double range_m = 0.0;
    double rate_mps = 0.0;
    std::uint8_t issue = 0;  ///< IODE; GLONASS: change bit and tb
  };
  std::array<Satellite, 18> satellites{};
};

/// 18 carrier phases, 19 pseudoranges; 20, 21 their corrections.
struct Rtcm2Observations {
  std::uint8_t band = 0;            ///< 1 = L1, 2 = L2, 0 = reserved code
  bool more_follow = false;         ///< other messages of the same time come after this one
  core::Duration time_of_second{};  ///< to be added to the header's time
  std::uint8_t count = 0;           ///< satellites in this message
  std::uint32_t gps_mask = 0;       ///< bit i: satellite i + 1
  std::uint32_t glonass_mask = 0;
};

/// 3: antenna phase centre (L1), resolution 1 cm. 24: antenna reference point, resolution 0.1 mm.
struct Rtcm2Station {
  Eigen::Vector3d ecef_m = Eigen::Vector3d::Zero();
  bool is_reference_point = false;  ///< 24
  bool has_antenna_height = false;
  double antenna_height_m = 0.0;
};

/// 22: add l1_m to the position of message 3 to get it in 1/256 cm.
struct Rtcm2StationOffset {
  Eigen::Vector3d l1_m = Eigen::Vector3d::Zero();
  bool has_antenna_height = false;
  double antenna_height_m = 0.0;
  bool has_l2 = false;
  Eigen::Vector3d l2_m = Eigen::Vector3d::Zero();
};

/// 23.
struct Rtcm2Antenna {
  std::array<char, 32> descriptor_chars{};
  std::array<char, 32> serial_chars{};
  std::uint8_t descriptor_length = 0;
  std::uint8_t serial_length = 0;
  std::uint8_t setup = 0;
  std::string_view descriptor() const { return {descriptor_chars.data(), descriptor_length}; }
  std::string_view serial() const { return {serial_chars.data(), serial_length}; }
};

struct Rtcm2Message {
  std::uint8_t type = 0;      ///< 1..64
  std::uint16_t station = 0;  ///< 0..1023
  core::Duration
      time_of_hour{};           ///< modified Z-count x 0.6 s; the hour is known from elsewhere only
  std::uint8_t sequence = 0;    ///< 0..7
  std::uint8_t health = 0;      ///< 0..7; 6 = not monitored, 7 = do not use
  std::uint8_t data_words = 0;  ///< after the two header words
  std::array<std::uint32_t, 31> data{};  ///< 24 bits each, parity taken off, inversion undone
  std::uint8_t bits_before =
      0;  ///< last two bits of the word before the header, as the parity of word 1 has them
  bool malformed = false;  ///< a type we know, with a length it cannot have; `body` is then empty
  std::variant<std::monostate, Rtcm2Corrections, Rtcm2Observations, Rtcm2Station,
               Rtcm2StationOffset, Rtcm2Antenna>
      body;  ///< empty for other types (59 proprietary, 6 null, 16 text, ...): `data` has them

  /// Stream bytes from the first to the last byte that carries this message, skipped bytes between
  /// included. Where messages are not byte-aligned, the byte on the seam counts for the earlier one
  /// only.
  std::size_t stream_bytes = 0;
  /// Bytes fed to the decoder up to and including this message's last byte.
  std::uint64_t stream_end = 0;
};

/// Fills `body` from type, data_words and data. Real-time safe, any thread.
void DecodeRtcm2Body(Rtcm2Message& message) noexcept;

/// Time of measurement within the hour: the header's time plus the observations' fraction.
core::Duration Rtcm2TimeOfHour(const Rtcm2Message& message) noexcept;

}  // namespace kawara::drivers
