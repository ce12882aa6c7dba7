#include "tools/log_common.hpp"

#include <unistd.h>

#include <charconv>
#include <cmath>
#include <kawara/config_t.hpp>

#include "comms/codec.hpp"
#include "core/iso8601.hpp"

namespace kawara::tools {
namespace {

core::Expected<std::optional<std::regex>> Pattern(const char* option, const std::string& text) {
  if (text.empty()) return std::optional<std::regex>();
  try {
    return std::optional<std::regex>(std::regex(text));
  } catch (const std::regex_error&) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      std::string(option) + " '" + text + "': not a regular expression");
  }
}

bool Matches(std::string_view channel, const std::regex& pattern) {
  return std::regex_match(channel.begin(), channel.end(), pattern);
}

}  // namespace

core::Expected<ChannelFilter> ChannelFilter::Make(const std::string& include,
                                                  const std::string& exclude) {
  ChannelFilter filter;
  auto included = Pattern("--include", include);
  if (!included) return tl::unexpected(included.error());
  auto excluded = Pattern("--exclude", exclude);
  if (!excluded) return tl::unexpected(excluded.error());
  filter.include_ = std::move(*included);
  filter.exclude_ = std::move(*excluded);
  return filter;
}

bool ChannelFilter::operator()(std::string_view channel) const {
  if (include_ && !Matches(channel, *include_)) return false;
  return !exclude_ || !Matches(channel, *exclude_);
}

core::Expected<comms::EventLogReader> OpenLogs(const std::vector<std::string>& paths) {
  return comms::EventLogReader::Open({paths.begin(), paths.end()});
}

void LogTypes::See(const comms::LogEvent& event) {
  if (event.channel != "CONFIG") return;
  const auto config = comms::Decode<config_t>(event.data);
  if (!config || config->lcmtypes.empty()) return;
  auto schema = comms::LcmSchema::Parse(config->lcmtypes);
  if (schema) from_log_.emplace(std::move(*schema));
}

const comms::LcmType* LogTypes::TypeOf(std::span<const std::uint8_t> message) const {
  const comms::LcmType* type = from_log_ ? from_log_->TypeOf(message) : nullptr;
  return type != nullptr ? type : comms::LcmSchema::Builtin().TypeOf(message);
}

std::string FormatTime(std::int64_t time_utc_us) {
  constexpr std::int64_t kMaxUs = 9'000'000'000'000'000;  // the year 2255
  if (time_utc_us < -kMaxUs || time_utc_us > kMaxUs) return "?";
  return core::FormatIso8601(core::UtcTime::FromNs(time_utc_us * 1000),
                             core::Iso8601Digits::kMicroseconds);
}

core::Expected<std::int64_t> ParseLogTime(const std::string& text, std::int64_t start_utc_us) {
  double seconds = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error == std::errc() && end == text.data() + text.size() && std::abs(seconds) < 1e9) {
    return start_utc_us + std::llround(seconds * 1e6);
  }
  const auto time = core::ParseIso8601(text);
  if (time) return time->ns() / 1000;
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "'" + text +
                        "' is neither seconds from the start of the log (12.5) nor a time "
                        "(2026-07-08T06:30:12.5Z)");
}

Progress::Progress(const comms::EventLogReader& reader)
    : reader_(reader), terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_percent_ >= 0) std::fputs("\r\033[K", stderr);
}

void Progress::Tick() {
  if (!terminal_ || ++ticks_ % 1024 != 0 || reader_.total_bytes() == 0) return;
  const double part =
      static_cast<double>(reader_.stats().bytes) / static_cast<double>(reader_.total_bytes());
  const int percent = static_cast<int>(100.0 * part);
  if (percent == shown_percent_) return;
  shown_percent_ = percent;
  std::fprintf(stderr, "\r%3d %%", percent);
}

void PrintDamage(std::FILE* out, const comms::LogReaderStats& stats, std::size_t max_lines) {
  if (stats.damage_count == 0) return;
  for (std::size_t i = 0; i < stats.damage.size() && i < max_lines; ++i) {
    const comms::LogDamage& damage = stats.damage[i];
    std::fprintf(out, "%s: bytes %llu to %llu: %s\n", damage.file.c_str(),
                 static_cast<unsigned long long>(damage.begin),
                 static_cast<unsigned long long>(damage.end), damage.what.c_str());
  }
  if (stats.damage_count > max_lines) {
    std::fprintf(out, "... and %llu more places\n",
                 static_cast<unsigned long long>(stats.damage_count - max_lines));
  }
  std::fprintf(out, "damage: %llu place(s), %llu bytes, %llu event(s) known to be lost there\n",
               static_cast<unsigned long long>(stats.damage_count),
               static_cast<unsigned long long>(stats.damaged_bytes),
               static_cast<unsigned long long>(stats.damaged_events));
}

}  // namespace kawara::tools
