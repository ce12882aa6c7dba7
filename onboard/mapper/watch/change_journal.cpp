#include "onboard/mapper/watch/change_journal.hpp"

#include <kawara/changed_object_t.hpp>
#include <map>
#include <system_error>
#include <utility>

#include "comms/codec.hpp"
#include "comms/event_log_reader.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;

core::Expected<void> Copy(const fs::path& from, comms::EventLogWriter& to) {
  auto reader = comms::EventLogReader::Open({from});
  if (!reader) return tl::unexpected(reader.error());
  while (const auto event = reader->Next())
    if (auto done = to.Append(event->time_utc_us, event->channel, event->data, {}); !done)
      return done;
  return {};
}

}  // namespace

core::Expected<std::vector<comms::ObjectReport>> ReadObjects(const fs::path& log) {
  auto reader = comms::EventLogReader::Open({log});
  if (!reader) return tl::unexpected(reader.error());
  std::map<std::string, comms::ObjectReport> newest;
  while (const auto event = reader->Next()) {
    if (event->channel != "OBJECT") continue;
    const auto message = comms::Decode<changed_object_t>(event->data);
    if (!message) continue;
    auto report = comms::FromMessage(*message);
    if (!report) continue;
    comms::ObjectReport& known = newest[report->object.uid];
    if (report->object.revision > known.object.revision) known = std::move(*report);
  }
  std::vector<comms::ObjectReport> objects;
  objects.reserve(newest.size());
  for (auto& [uid, report] : newest) objects.push_back(std::move(report));
  return objects;
}

core::Expected<ChangeJournal> ChangeJournal::Open(const fs::path& log, bool fresh) {
  std::error_code error;
  const bool there = fs::exists(log, error);
  const fs::path path = there ? fs::path(log.string() + ".part") : log;
  fs::remove(path, error);
  if (there && fresh) fs::remove(log, error);
  comms::LogWriterOptions options;
  options.sync_interval = core::kDay;  // Commit says when
  auto writer = comms::EventLogWriter::Create(there && fresh ? log : path, options);
  if (!writer) return tl::unexpected(writer.error());
  if (there && !fresh) {
    if (auto done = Copy(log, *writer); !done) return tl::unexpected(done.error());
    if (auto done = writer->Sync(); !done) return tl::unexpected(done.error());
    fs::rename(path, log, error);
    if (error) return core::Fail(core::ErrorCode::kIo, log.string() + ": " + error.message());
  }
  return ChangeJournal(std::move(*writer));
}

core::Expected<void> ChangeJournal::Append(std::string_view channel,
                                           const std::vector<std::uint8_t>& message,
                                           core::UtcTime time) {
  return writer_.Append(time.ns() / 1000, channel, message, {});
}

}  // namespace kawara::mapper
