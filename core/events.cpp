#include "core/events.hpp"

#include <cstring>

namespace kawara::core {

const char* ToString(Severity s) {
  switch (s) {
    case Severity::kInfo:
      return "info";
    case Severity::kWarnLow:
      return "warn-low";
    case Severity::kWarnHigh:
      return "warn-high";
    case Severity::kFatal:
      return "fatal";
  }
  return "info";
}

void Events::Push(MonoTime now, Severity severity, const char* name, const EventText& text) {
  bool is_new = false;
  Name& entry = Find(name, is_new);
  const Event event{now, severity, name, 0, text};
  if (is_new || severity == Severity::kFatal || severity > entry.last_severity ||
      IsOpen(entry, now)) {
    Emit(entry, event);
  } else {
    ++entry.suppressed;
    entry.held = event;
  }
}

void Events::Flush(MonoTime now) {
  for (std::size_t i = 0; i < names_used_; ++i) {
    Name& entry = names_[i];
    if (entry.suppressed == 0 || !IsOpen(entry, now)) continue;
    --entry.suppressed;  // the held one itself comes out now
    Emit(entry, entry.held);
    entry.last = now;
  }
}

Events::Name& Events::Find(const char* name, bool& is_new) {
  for (std::size_t i = 0; i < names_used_; ++i) {
    // The same literal may have two addresses in two translation units: compare the text.
    if (names_[i].name == name || std::strcmp(names_[i].name, name) == 0) return names_[i];
  }
  if (names_used_ == kMaxNames) return names_.back();
  is_new = true;
  Name& entry = names_[names_used_++];
  entry.name = name;
  return entry;
}

bool Events::IsOpen(const Name& entry, MonoTime now) const {
  return now < entry.last || now - entry.last >= throttle_;
}

void Events::Emit(Name& entry, const Event& event) {
  Event out = event;
  out.suppressed = entry.suppressed;
  entry.suppressed = 0;
  entry.last = event.stamp;
  entry.last_severity = event.severity;
  ring_.PushDroppingOldest(out);
}

}  // namespace kawara::core
