// Field parsers on every kind of contents. The fuzzer writes the text between '$' and '*'; the
// checksum is made right here, or next to nothing would get past it.
#include <cstdint>
#include <string>

#include "core/check.hpp"
#include "drivers/ashtech.hpp"
#include "drivers/nmea.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::drivers;
  const std::string body(reinterpret_cast<const char*>(data), size);
  constexpr std::string_view kHex = "0123456789abcdef";
  const std::uint8_t sum = NmeaChecksum(body);
  const std::string text = "$" + body + "*" + kHex[sum >> 4] + kHex[sum & 15U];
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()),
                                            text.size());
  const NmeaProbeResult probe = NmeaProbe(bytes);
  CORE_CHECK(probe.length <= bytes.size());
  if (probe.match != NmeaMatch::kSentence) return 0;

  const NmeaBody nmea = ParseNmea(probe.sentence);
  if (const auto* gga = std::get_if<NmeaGga>(&nmea)) {
    CORE_CHECK(!gga->has_position || (gga->lat_deg >= -90.0 && gga->lat_deg <= 90.0));
    CORE_CHECK(!gga->has_position || (gga->lon_deg >= -180.0 && gga->lon_deg <= 180.0));
    CORE_CHECK(gga->quality == 0 || (gga->has_position && gga->time_utc));
  }
  if (const auto* rmc = std::get_if<NmeaRmc>(&nmea)) {
    CORE_CHECK(!rmc->has_date || kawara::core::IsValid({rmc->year, rmc->month, rmc->day}));
  }
  const AshtechBody ashtech = ParseAshtech(probe.sentence);
  if (const auto* tag = std::get_if<AshtechTimeTag>(&ashtech)) {
    CORE_CHECK(tag->time_of_week.count() >= 0 && tag->time_of_week < kawara::core::kGpsWeek);
  }
  return 0;
}
