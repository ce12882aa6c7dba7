#include "drivers/ntrip_source.hpp"

#include <array>
#include <charconv>
#include <cstddef>

namespace kawara::drivers {
namespace {

template <class T>
std::optional<T> Number(std::string_view text) {
  T value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<NtripSource> ParseNtripSource(std::string_view line) {
  // STR;mountpoint;identifier;format;details;carrier;system;network;country;lat;lon;nmea;solution;generator;
  // compression;authentication;fee;bitrate;misc (misc may hold semicolons)
  constexpr std::size_t kFields = 18;
  std::array<std::string_view, kFields> field{};
  for (std::size_t i = 0; i < kFields; ++i) {
    const std::size_t end = line.find(';');
    field[i] = line.substr(0, end);
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  if (field[0] != "STR" || field[1].empty()) return std::nullopt;
  NtripSource s;
  s.mountpoint = field[1];
  s.identifier = field[2];
  s.format = field[3];
  s.format_details = field[4];
  s.carrier = Number<int>(field[5]).value_or(-1);
  s.systems = field[6];
  s.network = field[7];
  s.country = field[8];
  s.lat_deg = Number<double>(field[9]);
  s.lon_deg = Number<double>(field[10]);
  s.needs_gga = field[11] == "1";
  s.is_network = field[12] == "1";
  s.generator = field[13];
  s.compression = field[14];
  if (!field[15].empty()) s.authentication = field[15].front();
  s.fee = field[16] == "Y";
  s.bitrate_bps = Number<int>(field[17]).value_or(-1);
  return s;
}

std::string ListMountpoints(const std::vector<NtripSource>& sources, std::size_t max_chars) {
  if (sources.empty()) return "none";
  constexpr std::size_t kRoomForMore = 16;
  std::string text;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::string& name = sources[i].mountpoint;
    if (text.size() + name.size() + kRoomForMore > max_chars) {
      return text + (i > 0 ? " and " : "") + std::to_string(sources.size() - i) +
             (i > 0 ? " more" : " mountpoints");
    }
    if (i > 0) text += ", ";
    text += name;
  }
  return text;
}

}  // namespace kawara::drivers
