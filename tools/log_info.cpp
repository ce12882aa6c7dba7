#include <algorithm>
#include <cmath>
#include <kawara/config_t.hpp>
#include <map>

#include "comms/codec.hpp"
#include "tools/json_lines.hpp"
#include "tools/log_common.hpp"

namespace kawara::tools {
namespace {

// A damaged or hostile log may show any number of channels.
constexpr std::size_t kMaxChannels = 10'000;

/// How the times between events are spread, in steps of 1 %: the median and what is far above it,
/// whatever the log's length, in a few KB.
class Intervals {
 public:
  void Add(std::int64_t us) {
    if (us < 0) {
      ++backwards_;
      return;
    }
    const double step =
        us < 1 ? 0.0 : 1.0 + std::floor(std::log(static_cast<double>(us)) / kLogStep);
    ++counts_[static_cast<int>(step)];
    ++total_;
    largest_us_ = std::max(largest_us_, us);
  }
  double MedianSeconds() const {
    std::uint64_t below = 0;
    for (const auto& [step, count] : counts_) {
      below += count;
      if (2 * below >= total_) return Seconds(step);
    }
    return 0.0;
  }
  /// Longer than three times the median.
  std::uint64_t Gaps() const {
    const double limit_s = 3.0 * MedianSeconds();
    std::uint64_t gaps = 0;
    for (const auto& [step, count] : counts_) gaps += Seconds(step) > limit_s ? count : 0;
    return limit_s > 0.0 ? gaps : 0;
  }
  double LargestSeconds() const { return static_cast<double>(largest_us_) * 1e-6; }
  std::uint64_t backwards() const { return backwards_; }

 private:
  static constexpr double kLogStep = 0.01;
  static double Seconds(int step) {
    return step == 0 ? 0.0 : std::exp((step - 0.5) * kLogStep) * 1e-6;
  }
  std::map<int, std::uint64_t> counts_;
  std::uint64_t total_ = 0;
  std::uint64_t backwards_ = 0;
  std::int64_t largest_us_ = 0;
};

struct Channel {
  std::string type;
  std::uint64_t count = 0;
  std::uint64_t bytes = 0;
  std::uint64_t malformed = 0;  ///< known type, but not a message of it
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  Intervals intervals;

  double RatePerSecond() const {
    const double seconds = (static_cast<double>(last_us) - static_cast<double>(first_us)) * 1e-6;
    return count > 1 && seconds > 0.0 ? static_cast<double>(count - 1) / seconds : 0.0;
  }
};

struct Summary {
  std::map<std::string, Channel, std::less<>> channels;
  std::string program;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
};

std::int64_t Difference(std::int64_t later, std::int64_t earlier) {
  std::int64_t difference = 0;
  return __builtin_sub_overflow(later, earlier, &difference) ? 0 : difference;
}

Summary Summarize(comms::EventLogReader& reader) {
  Summary summary;
  LogTypes types;
  Progress progress(reader);
  bool any = false;
  while (const auto event = reader.Next()) {
    progress.Tick();
    types.See(*event);
    if (event->channel == "CONFIG" && summary.program.empty()) {
      if (const auto config = comms::Decode<config_t>(event->data)) {
        summary.program = config->program + " " + config->version;
      }
    }
    summary.first_us = any ? std::min(summary.first_us, event->time_utc_us) : event->time_utc_us;
    summary.last_us = any ? std::max(summary.last_us, event->time_utc_us) : event->time_utc_us;
    any = true;
    auto it = summary.channels.find(event->channel);
    if (it == summary.channels.end()) {
      const bool room = summary.channels.size() < kMaxChannels;
      it =
          summary.channels.try_emplace(room ? std::string(event->channel) : std::string("(others)"))
              .first;
    }
    Channel& channel = it->second;
    const comms::LcmType* type = types.TypeOf(event->data);
    const std::string type_name = type != nullptr ? type->name() : "unknown";
    if (channel.count == 0) channel.type = type_name;
    if (channel.type != type_name) channel.type = "several";
    if (type != nullptr && !type->Check(event->data)) ++channel.malformed;
    if (channel.count == 0) {
      channel.first_us = event->time_utc_us;
    } else {
      channel.intervals.Add(Difference(event->time_utc_us, channel.last_us));
    }
    channel.last_us = event->time_utc_us;
    channel.bytes += event->data.size();
    ++channel.count;
  }
  return summary;
}

unsigned long long Ull(std::uint64_t n) { return n; }

void PrintTable(const Summary& summary, const comms::EventLogReader& reader) {
  const comms::LogReaderStats& stats = reader.stats();
  const double seconds = static_cast<double>(Difference(summary.last_us, summary.first_us)) * 1e-6;
  std::printf("files     %llu, %.1f MB\n", Ull(stats.files),
              static_cast<double>(reader.total_bytes()) * 1e-6);
  if (!summary.program.empty()) std::printf("program   %s\n", summary.program.c_str());
  std::printf("time      %s to %s (%.1f s)\n", FormatTime(summary.first_us).c_str(),
              FormatTime(summary.last_us).c_str(), seconds);
  std::printf("events    %llu, %llu of them verified by CRC\n\n", Ull(stats.events),
              Ull(stats.verified));
  int width = 7;
  for (const auto& [name, channel] : summary.channels)
    width = std::max(width, static_cast<int>(name.size()));
  std::printf("%-*s  %-13s %9s %9s %9s %11s %7s %12s %10s %10s\n", width, "channel", "type",
              "count", "rate/s", "median_s", "largest_gap", "gaps>3x", "bytes", "first_s",
              "last_s");
  for (const auto& [name, c] : summary.channels) {
    std::printf("%-*s  %-13s %9llu %9.3f %9.4f %11.3f %7llu %12llu %10.3f %10.3f\n", width,
                name.c_str(), c.type.c_str(), Ull(c.count), c.RatePerSecond(),
                c.intervals.MedianSeconds(), c.intervals.LargestSeconds(), Ull(c.intervals.Gaps()),
                Ull(c.bytes), static_cast<double>(Difference(c.first_us, summary.first_us)) * 1e-6,
                static_cast<double>(Difference(c.last_us, summary.first_us)) * 1e-6);
  }
  std::printf("\n");
  for (const auto& [name, c] : summary.channels) {
    if (c.malformed > 0)
      std::printf("%s: %llu messages are no %s\n", name.c_str(), Ull(c.malformed), c.type.c_str());
    if (c.intervals.backwards() > 0) {
      std::printf("%s: the recording computer's clock went back %llu times\n", name.c_str(),
                  Ull(c.intervals.backwards()));
    }
  }
  if (stats.missing_numbers > 0) {
    std::printf(
        "%llu event numbers are not in these files (lost, given up for space, or in files not "
        "named here)\n",
        Ull(stats.missing_numbers));
  }
  PrintDamage(stdout, stats, 10);
  if (stats.damage_count == 0) std::printf("damage: none\n");
}

void PrintJson(const Summary& summary, const comms::EventLogReader& reader) {
  const comms::LogReaderStats& stats = reader.stats();
  JsonLines out(stdout);
  out.BeginBare();
  out.Unsigned("files", stats.files);
  out.Unsigned("bytes", reader.total_bytes());
  out.Text("program", summary.program);
  out.Text("first", FormatTime(summary.first_us));
  out.Text("last", FormatTime(summary.last_us));
  out.Number("duration_s",
             static_cast<double>(Difference(summary.last_us, summary.first_us)) * 1e-6, 6);
  out.Unsigned("events", stats.events);
  out.Unsigned("verified", stats.verified);
  out.Unsigned("missing_numbers", stats.missing_numbers);
  out.OpenObject("channels");
  for (const auto& [name, c] : summary.channels) {
    out.OpenObject(name);
    out.Text("type", c.type);
    out.Unsigned("count", c.count);
    out.Number("rate_per_s", c.RatePerSecond(), 6);
    out.Number("median_period_s", c.intervals.MedianSeconds(), 6);
    out.Number("largest_gap_s", c.intervals.LargestSeconds(), 6);
    out.Unsigned("gaps_over_3_periods", c.intervals.Gaps());
    out.Unsigned("clock_went_back", c.intervals.backwards());
    out.Unsigned("bytes", c.bytes);
    out.Unsigned("malformed", c.malformed);
    out.Text("first", FormatTime(c.first_us));
    out.Text("last", FormatTime(c.last_us));
    out.CloseObject();
  }
  out.CloseObject();
  out.OpenObject("damage");
  out.Unsigned("places", stats.damage_count);
  out.Unsigned("bytes", stats.damaged_bytes);
  out.Unsigned("events", stats.damaged_events);
  out.Unsigned("unreadable_bytes", stats.unreadable_bytes);
  out.OpenArray("ranges");
  for (const comms::LogDamage& damage : stats.damage) {
    out.OpenObject("");
    out.Text("file", damage.file);
    out.Unsigned("begin", damage.begin);
    out.Unsigned("end", damage.end);
    out.Text("what", damage.what);
    out.CloseObject();
  }
  out.CloseArray();
  out.CloseObject();
  out.End();
  (void)out.Flush();
}

}  // namespace

core::Expected<int> LogInfo(const std::vector<std::string>& paths, bool json) {
  auto reader = OpenLogs(paths);
  if (!reader) return tl::unexpected(reader.error());
  const Summary summary = Summarize(*reader);
  if (json) {
    PrintJson(summary, *reader);
  } else if (reader->stats().events == 0) {
    std::printf("no events in %llu file(s) of %llu bytes\n", Ull(reader->stats().files),
                Ull(reader->total_bytes()));
    PrintDamage(stdout, reader->stats(), 10);
  } else {
    PrintTable(summary, *reader);
  }
  return 0;
}

core::Expected<int> LogCheck(const std::vector<std::string>& paths) {
  auto reader = OpenLogs(paths);
  if (!reader) return tl::unexpected(reader.error());
  const Summary summary = Summarize(*reader);
  const comms::LogReaderStats& stats = reader->stats();
  std::uint64_t malformed = 0;
  for (const auto& [name, c] : summary.channels) {
    malformed += c.malformed;
    if (c.malformed > 0)
      std::printf("%s: %llu messages are no %s\n", name.c_str(), Ull(c.malformed), c.type.c_str());
  }
  PrintDamage(stdout, stats, stats.damage.size());
  const bool clean = stats.damage_count == 0 && malformed == 0;
  std::printf("%s: %llu events in %llu file(s), %llu verified by CRC, %llu numbers missing\n",
              clean ? "clean" : "damaged", Ull(stats.events), Ull(stats.files), Ull(stats.verified),
              Ull(stats.missing_numbers));
  return clean ? 0 : 1;
}

}  // namespace kawara::tools
