#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "core/fixed_text.hpp"
#include "core/time.hpp"
#include "drivers/ashtech.hpp"
#include "drivers/ashtech_binary.hpp"
#include "drivers/nmea.hpp"
#include "drivers/rtcm2.hpp"
#include "drivers/rtcm3.hpp"
#include "drivers/ubx.hpp"

namespace kawara::drivers {

/// A binary Ashtech record that is recognised and skipped whole.
struct AshtechRecord {
  core::FixedText<4> type;  ///< "MCA"
};

/// One whole message of a GNSS receiver's (or a base's) byte stream, with the right checksum.
struct GnssMessage {
  using Body = std::variant<NmeaBody, AshtechBody, AshtechPbn, AshtechRecord, Rtcm3Message,
                            const Rtcm2Message*, UbxMessage>;

  core::MonoTime arrival;    ///< of the first byte (RTCM 2: of the last)
  std::uint64_t offset = 0;  ///< of the first byte in the stream
  std::span<const std::uint8_t>
      bytes;  ///< without a closing CR LF; empty for RTCM 2, whose bytes may be scattered
  NmeaSentence sentence;  ///< of text messages
  Body body;              ///< pointers and views are valid during the call only

  template <class T>
  const T* As() const {
    return std::get_if<T>(&body);
  }
  /// The contents, if the message is text of this kind: Nmea<NmeaGga>().
  template <class T>
  const T* Nmea() const {
    const auto* nmea = std::get_if<NmeaBody>(&body);
    return nmea == nullptr ? nullptr : std::get_if<T>(nmea);
  }
  template <class T>
  const T* Ashtech() const {
    const auto* ashtech = std::get_if<AshtechBody>(&body);
    return ashtech == nullptr ? nullptr : std::get_if<T>(ashtech);
  }
};

using GnssTypeName = core::FixedText<20>;
/// "GPGGA", "PASHR", "PBN", "MCA", "RTCM3.1004", "RTCM2.18", "UBX.01.07". All $PASHR text is
/// "PASHR".
GnssTypeName TypeName(const GnssMessage& message);
/// Right checksum, but contents that its type cannot have: do not use it.
bool IsInvalid(const GnssMessage& message);

}  // namespace kawara::drivers
