#pragma once
#include <cstdint>
#include <cstdio>
#include <optional>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "comms/event_log_reader.hpp"
#include "comms/lcm_schema.hpp"
#include "core/expected.hpp"

/// What the commands of kawara-log share.
namespace kawara::tools {

/// Which channels: all, those that match `include`, without those that match `exclude`. Regular
/// expressions that must match the whole name; empty: no restriction.
class ChannelFilter {
 public:
  [[nodiscard]] static core::Expected<ChannelFilter> Make(const std::string& include,
                                                          const std::string& exclude);
  bool operator()(std::string_view channel) const;

 private:
  std::optional<std::regex> include_;
  std::optional<std::regex> exclude_;
};

/// Opens what the user named.
[[nodiscard]] core::Expected<comms::EventLogReader> OpenLogs(const std::vector<std::string>& paths);

/// The types a log was written with, from its CONFIG; those of this program where it has none.
class LogTypes {
 public:
  /// Takes note if the event is a CONFIG that carries types.
  void See(const comms::LogEvent& event);
  /// Null: no type known with the fingerprint of this message.
  const comms::LcmType* TypeOf(std::span<const std::uint8_t> message) const;

 private:
  std::optional<comms::LcmSchema> from_log_;
};

/// "2026-07-08T06:30:00.123456Z"; "?" for a stamp that is no time of any calendar.
std::string FormatTime(std::int64_t time_utc_us);

/// A point in a log: "12.5" is seconds from its first event, "2026-07-08T06:30:12.5Z" is UTC.
[[nodiscard]] core::Expected<std::int64_t> ParseLogTime(const std::string& text,
                                                        std::int64_t start_utc_us);

/// A line of how far the reading is, on a terminal only; gone when done.
class Progress {
 public:
  explicit Progress(const comms::EventLogReader& reader);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void Tick();

 private:
  const comms::EventLogReader& reader_;
  bool terminal_;
  unsigned ticks_ = 0;
  int shown_percent_ = -1;
};

/// One line for every damaged place, then what it cost. Nothing if the log is whole.
void PrintDamage(std::FILE* out, const comms::LogReaderStats& stats, std::size_t max_lines);

struct CutOptions {
  std::string from;
  std::string to;
  std::string out;
  std::string include;
  std::string exclude;
};
struct ExportOptions {
  std::string channel;
  std::string out;
  std::string pictures;  ///< folder; empty: none
};

/// The commands: what they print goes to standard output; the result is the exit status.
[[nodiscard]] core::Expected<int> LogInfo(const std::vector<std::string>& paths, bool json);
[[nodiscard]] core::Expected<int> LogCheck(const std::vector<std::string>& paths);
[[nodiscard]] core::Expected<int> LogCut(const std::vector<std::string>& paths,
                                         const CutOptions& options);
[[nodiscard]] core::Expected<int> LogExport(const std::vector<std::string>& paths,
                                            const ExportOptions& options);

}  // namespace kawara::tools
