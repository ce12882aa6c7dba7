#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/expected.hpp"

/// Telegrams of SICK's PLS-101 and LMS2xx laser scanners: frame, CRC and the commands to the
/// scanner.
///
///   STX 0x02 | address | length LSB, MSB | command | data ... | CRC LSB, MSB
/// Length counts command and data (in replies the last data byte is the scanner's status). To the
/// scanner the address is its own (0), from it 0x80 is added. Before its reply the scanner sends
/// one byte, ACK 0x06 or NAK 0x15. Reply command = request + 0x80; 0x92 = not accepted.
///
/// Sources: Player's sickpls driver, the PLS-101-312 driver of T. Weis, ROS SickPLS200, sicktoolbox
/// (LMS2xx and its PLS fork) and DTU's USick agree on all of this; a recorded LMS scan (USick)
/// checks with its CRC.
namespace kawara::drivers {

constexpr std::uint8_t kSickStx = 0x02;
constexpr std::uint8_t kSickAck = 0x06;
constexpr std::uint8_t kSickNak = 0x15;
constexpr std::size_t kSickOverheadBytes = 6;  ///< STX, address, length, CRC
constexpr std::size_t kSickMaxLength = 2048;   ///< longest is 0.25 deg over 100 deg: 806; with room

/// Starts at 0; each byte: shift left, XOR 0x8005 if the top bit fell out, XOR this byte and the
/// one before it (times 256). Not a plain CRC-16: that pairs the bytes differently.
std::uint16_t SickCrc(std::span<const std::uint8_t> bytes);

/// A telegram to the scanner, ready to write. At least 55 us must lie between its bytes
/// (sicktoolbox), which every baud rate below 180000 gives by itself.
struct SickTelegram {
  std::array<std::uint8_t, 64> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> view() const { return {bytes.data(), size}; }
};

/// `payload` (command and data) of at most 58 bytes; more is our own bug.
SickTelegram MakeSickTelegram(std::uint8_t address, std::span<const std::uint8_t> payload);

/// Commands to the scanner at `address`.
class SickCommands {
 public:
  explicit SickCommands(std::uint8_t address = 0) : address_(address) {}

  SickTelegram Reset() const;          ///< 0x10
  SickTelegram RequestStatus() const;  ///< 0x31, reply 0xB1
  SickTelegram RequestType() const;    ///< 0x3A, reply 0xBA
  SickTelegram RequestScan() const;    ///< 0x30 0x01, reply 0xB0
  SickTelegram StreamAll() const;      ///< mode 0x24, reply 0xA0, then 0xB0 again and again
  SickTelegram OnRequest() const;      ///< mode 0x25: stops the stream
  SickTelegram StreamRange(std::uint16_t first,
                           std::uint16_t last) const;  ///< mode 0x27, reply 0xB7
  /// Mode 0x00 with the 8-character password: SICK_PLS on a PLS, SICK_LMS on an LMS, LASERFUN seen
  /// on a PLS 101-312. kInvalidArgument if it is not 8 characters.
  core::Expected<SickTelegram> Installation(std::string_view password) const;
  /// Modes 0x42, 0x41, 0x40, 0x48 for 9600, 19200, 38400, 500000 (RS-422 only, unproven on a PLS).
  /// After the scanner's ACK both sides change. kInvalidArgument for other rates.
  core::Expected<SickTelegram> SetBaud(int baud_bps) const;

 private:
  SickTelegram Mode(std::uint8_t mode) const;
  std::uint8_t address_;
};

}  // namespace kawara::drivers
