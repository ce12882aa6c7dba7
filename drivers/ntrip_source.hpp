#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kawara::drivers {

/// A STR record of a caster's source table. Source: RTCM 10410.1, source table.
struct NtripSource {
  std::string mountpoint;
  std::string identifier;  ///< town, mostly
  std::string format;      ///< "RTCM 3.2", "RTCM 2.3", "CMR", ...
  std::string format_details;
  int carrier = -1;  ///< 0 none, 1 L1, 2 L1 and L2; -1 unknown, as all numbers that are not there
  std::string systems;
  std::string network;
  std::string country;
  std::optional<double> lat_deg, lon_deg;
  bool needs_gga = false;  ///< sends nothing useful before it knows where the rover is
  bool is_network = false;
  std::string generator;
  std::string compression;
  char authentication = 'N';  ///< N none, B basic, D digest
  bool fee = false;
  int bitrate_bps = -1;
};

/// One line without CR LF. Empty if it is not a STR record with a mountpoint; missing fields at the
/// end are allowed.
std::optional<NtripSource> ParseNtripSource(std::string_view line);

/// "A, B, C and 12 more", at most `max_chars` long; "none" for an empty table. For error lines.
std::string ListMountpoints(const std::vector<NtripSource>& sources, std::size_t max_chars);

}  // namespace kawara::drivers
