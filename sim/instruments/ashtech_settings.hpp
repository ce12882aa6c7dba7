#pragma once
#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/time.hpp"

namespace kawara::sim {

/// What a Z-Family receiver can be told to send. Source: Z-Family Technical Reference Manual
/// 630203-01, chapter 6, "NMEA Data Message Commands"; GST and LTN are of the heirs of the family.
enum class AshtechMessage : std::uint8_t {
  // In this order within an epoch.
  kGga,
  kRmc,
  kVtg,
  kGst,
  kGsa,
  kPos,
  kCbn,
  kLtn,
  kZda,
  // At instants of their own.
  kPtt,
  kTtt,
  // Accepted and acknowledged, but nothing comes: the recording holds no data of single satellites
  // or base.
  kAlm,
  kDal,
  kGdc,
  kGll,
  kGrs,
  kGsn,
  kGsv,
  kGxp,
  kMsg,
  kRre,
  kSat,
  kUtm,
  kXdr,
  kXte,
  kCount
};
using AshtechMessages = std::bitset<static_cast<std::size_t>(AshtechMessage::kCount)>;
std::optional<AshtechMessage> AshtechMessageNamed(std::string_view three_letters);
const char* ToString(AshtechMessage message);

constexpr int kAshtechPorts = 4;  ///< A..D

/// Everything $PASHS changes here. A fresh one is what $PASHS,RST leaves: all output off, 9600
/// baud.
struct AshtechSettings {
  struct Port {
    int baud_code = 5;
    AshtechMessages on;
  };
  std::array<Port, kAshtechPorts> ports;
  core::Duration nmea_period = core::Seconds(1);
  core::Duration raw_period = core::Seconds(20);  ///< RCI: period of CBN
  core::Duration pps_period = core::Seconds(1);   ///< zero: off
  core::Duration pps_offset{};
  char pps_edge = 'R';
  char event_edge = 'R';
  std::optional<int> corrections_port;  ///< RTC,REM
  core::Duration corrections_max_age = core::Seconds(60);
  bool rover = false;  ///< CPD,MOD,ROV was accepted
  bool cpd_works =
      false;  ///< ... after RTC,REM, and no RTC,REM since: the order that keeps CPD alive
  bool fast_cpd = true;
};

/// Baud rate of an Ashtech code 0..9; 0 if there is none.
int AshtechBaud(int code);
/// Code of a baud rate.
std::optional<int> AshtechBaudCode(int baud_bps);

/// What came of one command line.
struct AshtechReply {
  std::string text;  ///< one or more lines with CR LF, to be sent at the OLD baud rate
  std::optional<AshtechMessage> once;  ///< $PASHQ of a message: send it now
  bool reset = false;                  ///< back to defaults
  std::optional<bool> save;            ///< SAV,Y / SAV,N
};

/// Obeys one line of the Ashtech command language, without CR LF, starting at '$', received on
/// `port` (0 = A). A checksum may be missing; a wrong one, an unknown command or a bad argument is
/// answered $PASHR,NAK and changes nothing. Source: Z-Family Technical Reference Manual, chapter 6.
AshtechReply ObeyAshtech(std::string_view line, int port, AshtechSettings& settings);

/// "$" + body + "*hh" CR LF.
std::string WithChecksum(std::string_view body);

}  // namespace kawara::sim
