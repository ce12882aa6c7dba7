#include "drivers/sick_telegram.hpp"

#include <algorithm>
#include <string>

#include "core/check.hpp"

namespace kawara::drivers {

std::uint16_t SickCrc(std::span<const std::uint8_t> bytes) {
  constexpr unsigned kPolynomial = 0x8005;
  unsigned crc = 0;
  unsigned previous = 0;
  for (const std::uint8_t byte : bytes) {
    const bool carry = (crc & 0x8000U) != 0;
    crc = (crc << 1) & 0xFFFFU;
    if (carry) crc ^= kPolynomial;
    crc ^= byte | (previous << 8);
    previous = byte;
  }
  return static_cast<std::uint16_t>(crc);
}

SickTelegram MakeSickTelegram(std::uint8_t address, std::span<const std::uint8_t> payload) {
  SickTelegram telegram;
  CORE_CHECK(!payload.empty() && payload.size() + kSickOverheadBytes <= telegram.bytes.size());
  telegram.bytes[0] = kSickStx;
  telegram.bytes[1] = address;
  telegram.bytes[2] = static_cast<std::uint8_t>(payload.size() & 0xFFU);
  telegram.bytes[3] = static_cast<std::uint8_t>(payload.size() >> 8);
  std::copy(payload.begin(), payload.end(), telegram.bytes.begin() + 4);
  const std::size_t body = 4 + payload.size();
  const std::uint16_t crc = SickCrc(std::span(telegram.bytes).first(body));
  telegram.bytes[body] = static_cast<std::uint8_t>(crc & 0xFFU);
  telegram.bytes[body + 1] = static_cast<std::uint8_t>(crc >> 8);
  telegram.size = body + 2;
  return telegram;
}

namespace {

template <std::size_t N>
SickTelegram Make(std::uint8_t address, const std::uint8_t (&payload)[N]) {
  return MakeSickTelegram(address, std::span<const std::uint8_t>(payload));
}

}  // namespace

SickTelegram SickCommands::Mode(std::uint8_t mode) const { return Make(address_, {0x20, mode}); }
SickTelegram SickCommands::Reset() const { return Make(address_, {0x10}); }
SickTelegram SickCommands::RequestStatus() const { return Make(address_, {0x31}); }
SickTelegram SickCommands::RequestType() const { return Make(address_, {0x3A}); }
SickTelegram SickCommands::RequestScan() const { return Make(address_, {0x30, 0x01}); }
SickTelegram SickCommands::StreamAll() const { return Mode(0x24); }
SickTelegram SickCommands::OnRequest() const { return Mode(0x25); }

SickTelegram SickCommands::StreamRange(std::uint16_t first, std::uint16_t last) const {
  const auto low = [](std::uint16_t v) { return static_cast<std::uint8_t>(v & 0xFFU); };
  const auto high = [](std::uint16_t v) { return static_cast<std::uint8_t>(v >> 8); };
  return Make(address_, {0x20, 0x27, low(first), high(first), low(last), high(last)});
}

core::Expected<SickTelegram> SickCommands::Installation(std::string_view password) const {
  if (password.size() != 8) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "scanner password \"" + std::string(password) +
                          "\" must have 8 characters, as SICK_PLS or SICK_LMS");
  }
  std::array<std::uint8_t, 10> payload{0x20, 0x00};
  std::transform(password.begin(), password.end(), payload.begin() + 2,
                 [](char c) { return static_cast<std::uint8_t>(c); });
  return MakeSickTelegram(address_, payload);
}

core::Expected<SickTelegram> SickCommands::SetBaud(int baud_bps) const {
  switch (baud_bps) {
    case 9600:
      return Mode(0x42);
    case 19200:
      return Mode(0x41);
    case 38400:
      return Mode(0x40);
    case 500000:
      return Mode(0x48);
    default:
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "scanner baud rate " + std::to_string(baud_bps) +
                            ": expected 9600, 19200, 38400 or 500000");
  }
}

}  // namespace kawara::drivers
