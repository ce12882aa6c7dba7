#include <limits>

#include "comms/event_log_writer.hpp"
#include "tools/log_common.hpp"

namespace kawara::tools {

// The first CONFIG is kept wherever the cut begins: without it nobody knows in ten years what the
// bytes mean.
core::Expected<int> LogCut(const std::vector<std::string>& paths, const CutOptions& options) {
  const auto wanted = ChannelFilter::Make(options.include, options.exclude);
  if (!wanted) return tl::unexpected(wanted.error());
  // Seconds count from the first event, which is not known yet: a first look at how the times are
  // written.
  for (const std::string* time : {&options.from, &options.to}) {
    if (const auto ok = ParseLogTime(time->empty() ? "0" : *time, 0); !ok)
      return tl::unexpected(ok.error());
  }
  auto reader = OpenLogs(paths);
  if (!reader) return tl::unexpected(reader.error());
  auto writer = comms::EventLogWriter::Create(
      options.out, {.sync_interval = core::Seconds(1), .fdatasync = false});
  if (!writer) return tl::unexpected(writer.error());

  std::int64_t from_us = std::numeric_limits<std::int64_t>::min();
  std::int64_t to_us = std::numeric_limits<std::int64_t>::max();
  bool first = true;
  bool have_config = false;
  Progress progress(*reader);
  while (const auto event = reader->Next()) {
    progress.Tick();
    if (first) {
      if (!options.from.empty()) from_us = *ParseLogTime(options.from, event->time_utc_us);
      if (!options.to.empty()) to_us = *ParseLogTime(options.to, event->time_utc_us);
      first = false;
    }
    const bool first_config = event->channel == "CONFIG" && !have_config;
    have_config |= first_config;
    const bool in_time = event->time_utc_us >= from_us && event->time_utc_us < to_us;
    if (!first_config && !(in_time && (*wanted)(event->channel))) continue;
    const auto now = core::MonoTime::FromNs(0);
    if (auto ok = writer->Append(event->time_utc_us, event->channel, event->data, now); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  if (auto ok = writer->Sync(); !ok) return tl::unexpected(ok.error());
  const comms::LogReaderStats& stats = reader->stats();
  std::printf("%s: %llu of %llu events, %llu bytes\n", options.out.c_str(),
              static_cast<unsigned long long>(writer->synced_events()),
              static_cast<unsigned long long>(stats.events),
              static_cast<unsigned long long>(writer->bytes()));
  PrintDamage(stdout, stats, 10);
  return 0;
}

}  // namespace kawara::tools
