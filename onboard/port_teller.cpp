#include "onboard/port_teller.hpp"

namespace kawara::onboard {

void PortTeller::Tell(State state, core::Severity severity, std::string_view text) {
  state_ = state;
  PortNote note;
  note.port = port_;
  note.open = state == State::kUp;
  note.changed = true;
  note.severity = severity;
  note.text = text;
  const NoteBytes bytes = Pack(note);
  inbox_.Post(InputKind::kPort, core::MonoNow(), BytesOf(bytes.view()));
}

}  // namespace kawara::onboard
