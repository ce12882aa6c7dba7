#pragma once
#include <filesystem>
#include <string_view>
#include <vector>

#include "comms/event_log_writer.hpp"
#include "comms/object_message.hpp"
#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::mapper {

/// Objects of a log of channel OBJECT, newest revision of each, those that are gone too. Errors:
/// those of EventLogReader; a message that is none is left out.
core::Expected<std::vector<comms::ObjectReport>> ReadObjects(const std::filesystem::path& log);

/// What a run has told of changes, as an LCM log in the folder of its model: a run that goes on
/// takes its objects up from it, the next mission can, and kawara-station puts it into a GIS. One
/// thread.
class ChangeJournal {
 public:
  /// Goes on with the log that is there (its readable messages are written anew, and the new file
  /// takes the old one's place when it is whole), or begins one; `fresh`: forgets it. Errors: those
  /// of the reader and writer.
  static core::Expected<ChangeJournal> Open(const std::filesystem::path& log, bool fresh);

  /// `time`: of the message, for people and replay. Errors: those of EventLogWriter; the message is
  /// kept and tried again with the next one.
  core::Expected<void> Append(std::string_view channel, const std::vector<std::uint8_t>& message,
                              core::UtcTime time);
  /// What was appended is on the disk. Errors: those of EventLogWriter.
  core::Expected<void> Commit() { return writer_.Sync(); }

 private:
  explicit ChangeJournal(comms::EventLogWriter writer) : writer_(std::move(writer)) {}
  comms::EventLogWriter writer_;
};

}  // namespace kawara::mapper
