#include "onboard/pps_reader.hpp"

#include "onboard/realtime.hpp"

namespace kawara::onboard {

PpsReader::PpsReader(drivers::PpsSource& source, InputInbox& inbox, core::Counters& counters)
    : source_(source),
      inbox_(inbox),
      edges_(counters.Register("pps.edges")),
      thread_([this] { Run(); }) {}

PpsReader::~PpsReader() { Stop(); }

void PpsReader::Stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void PpsReader::Run() {
  BecomeBackground("pps", -5);
  while (!stopping_.load(std::memory_order_relaxed)) {
    const auto edge = source_.Next(core::Milliseconds(200));
    if (edge) {
      if (!was_up_) Tell(true, core::Severity::kInfo, "the pulse line is there");
      if (*edge) {
        edges_.Add();
        inbox_.Post(InputKind::kPulse, (*edge)->mono, Pack((*edge)->sequence));
      }
      continue;
    }
    if (was_up_ || !was_told_) Tell(false, core::Severity::kWarnHigh, edge.error().message);
    // The next call tries to connect again; not in a tight loop.
    std::this_thread::sleep_for(core::Milliseconds(200));
  }
}

void PpsReader::Tell(bool open, core::Severity severity, std::string_view text) {
  was_up_ = open;
  was_told_ = true;
  PortNote note;
  note.port = PortId::kPps;
  note.open = open;
  note.changed = true;
  note.severity = severity;
  note.text = text;
  const NoteBytes bytes = Pack(note);
  inbox_.Post(InputKind::kPort, core::MonoNow(), BytesOf(bytes.view()));
}

}  // namespace kawara::onboard
