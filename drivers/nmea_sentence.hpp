#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// Framing of NMEA 0183 text, of the receivers' private sentences in the same clothes ($PASHR,...),
/// and of nothing else: what the fields mean is in nmea.hpp and ashtech.hpp.
namespace kawara::drivers {

/// Longest sentence accepted, '$' to checksum. The standard's 82 characters are long outgrown:
/// every RTK receiver prints more digits than fit.
constexpr std::size_t kNmeaMaxBytes = 1024;

/// A sentence with the right checksum. Views into the caller's bytes.
struct NmeaSentence {
  std::string_view address;  ///< "GPGGA", "PASHR", "PUBX"
  std::string_view
      fields;  ///< what follows the first comma, up to the '*'; empty if there is no comma
  bool has_fields = false;  ///< there was a comma

  /// 'P' addresses belong to makers: no talker.
  bool is_proprietary() const { return address.size() >= 2 && address[0] == 'P'; }
  std::string_view talker() const { return is_proprietary() ? "P" : address.substr(0, 2); }
  std::string_view type() const { return is_proprietary() ? address.substr(1) : address.substr(2); }
};

enum class NmeaMatch : std::uint8_t {
  kNoMatch,      ///< cannot be a sentence: go on one byte later
  kNeedMore,     ///< so far so good
  kSentence,     ///< head[0, length) is a sentence with the right checksum; CR LF may follow
  kBadChecksum,  ///< head[0, length) looks like one but its checksum is wrong
};
struct NmeaProbeResult {
  NmeaMatch match = NmeaMatch::kNoMatch;
  /// Bytes from '$' to the second checksum digit; for kNoMatch how far the text went before it
  /// broke.
  std::size_t length = 0;
  NmeaSentence sentence;  ///< of kSentence
};

/// Looks whether a sentence begins at head[0]: '$', an address of 3..15 capital letters and digits,
/// printable characters, '*', two hexadecimal digits of either case that are the XOR of all
/// characters between. Pure: the answer for a longer `head` never contradicts one already given. A
/// '$' or a control character inside means that the sentence was cut off. Real-time safe.
NmeaProbeResult NmeaProbe(std::span<const std::uint8_t> head) noexcept;

/// XOR of all bytes: the checksum of the text between '$' and '*'.
std::uint8_t NmeaChecksum(std::string_view text) noexcept;

}  // namespace kawara::drivers
