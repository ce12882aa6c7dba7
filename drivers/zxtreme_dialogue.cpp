#include "drivers/zxtreme_dialogue.hpp"

#include <cmath>

namespace kawara::drivers {
namespace {

/// Commands in a row without an answer until a receiver that did answer is given up.
constexpr int kSilentSteps = 3;
/// Steps that find out whether anybody is there: RID and PRT.
constexpr std::size_t kProbeSteps = 2;

/// As it is shown to people: without CR LF.
std::string_view Shown(const ZXtremeCommand& command) {
  const std::string_view text = command.view();
  return text.substr(0, text.find('\r'));
}

bool Near(double a, double b) { return std::abs(a - b) < 1e-3; }

}  // namespace

void ZXtremeDialogue::Start(core::MonoTime now) {
  state_ = State::kAsking;
  step_ = 0;
  try_ = 0;
  waiting_ = alive_ = false;
  silent_steps_ = failed_ = 0;
  send_after_ = now;
  data_port_ = config_.data_port;
  identity_ = {};
  said_ = {};
}

void ZXtremeDialogue::OnMessage(core::MonoTime now, const GnssMessage& message,
                                core::Events& events) {
  if (state_ != State::kAsking || !waiting_) return;
  if (const auto* text = message.Ashtech<AshtechText>()) said_ = text->text;
  if (const auto* ack = message.Ashtech<AshtechAck>()) OnAck(now, ack->accepted, events);
  if (const auto* rid = message.Ashtech<AshtechIdentity>()) OnIdentity(now, *rid, events);
  if (const auto* port = message.Ashtech<AshtechPort>()) OnPort(now, *port, events);
  if (const auto* pps = message.Ashtech<AshtechPps>()) OnPps(now, *pps, events);
  if (const auto* edge = message.Ashtech<AshtechEventEdge>()) OnEventEdge(now, *edge, events);
}

void ZXtremeDialogue::OnAck(core::MonoTime now, bool accepted, core::Events& events) {
  alive_ = true;
  silent_steps_ = 0;
  if (!accepted) {
    FailStep(now, "refused (NAK)", events);
    NextStep(now);
  } else if (step().reply == ZXtremeReply::kAck) {
    NextStep(now);
  }
}

void ZXtremeDialogue::OnIdentity(core::MonoTime now, const AshtechIdentity& identity,
                                 core::Events& events) {
  if (step().reply != ZXtremeReply::kIdentity) return;
  alive_ = true;
  silent_steps_ = 0;
  identity_ = identity.text;
  if (identity_.view() != told_identity_.view()) {  // again after a change of baud rate
    told_identity_ = identity_;
    core::EventText text("receiver ");
    events.Info(now, "gps.identity", text.Append(identity_.view()));
  }
  NextStep(now);
}

void ZXtremeDialogue::OnPort(core::MonoTime now, const AshtechPort& port, core::Events& events) {
  if (step().reply != ZXtremeReply::kPort) return;
  alive_ = true;
  silent_steps_ = 0;
  if (port.port != config_.data_port) {
    core::EventText text("configured data port ");
    text.Append(std::string_view(&config_.data_port, 1)).Append(", but the receiver hears us on ");
    text.Append(std::string_view(&port.port, 1)).Append(": using that one");
    events.WarnLow(now, "gps.setup.port", text);
  }
  data_port_ = port.port;
  NextStep(now);
}

void ZXtremeDialogue::OnPps(core::MonoTime now, const AshtechPps& pps, core::Events& events) {
  if (step().reply != ZXtremeReply::kPps) return;
  silent_steps_ = 0;
  const bool off = config_.pps_period_s == 0.0 && pps.period_s == 0.0;
  const bool as_asked = Near(pps.period_s, config_.pps_period_s) &&
                        Near(pps.offset_ms, config_.pps_offset_ms) && pps.edge == config_.pps_edge;
  if (!off && !as_asked) {
    core::FixedText<96> what("says ");
    what.Append(pps.period_s, 1)
        .Append(" s, offset ")
        .Append(pps.offset_ms, 4)
        .Append(" ms, edge ");
    FailStep(now, what.Append(std::string_view(&pps.edge, 1)).view(), events);
  }
  NextStep(now);
}

void ZXtremeDialogue::OnEventEdge(core::MonoTime now, const AshtechEventEdge& edge,
                                  core::Events& events) {
  if (step().reply != ZXtremeReply::kEventEdge) return;
  silent_steps_ = 0;
  if (edge.edge != config_.event_edge) {
    core::FixedText<96> what("says edge ");
    FailStep(now, what.Append(std::string_view(&edge.edge, 1)).view(), events);
  }
  NextStep(now);
}

ZXtremeCommand ZXtremeDialogue::Poll(core::MonoTime now, core::Events& events) {
  if (state_ != State::kAsking) return {};
  if (waiting_) {
    if (now < deadline_) return {};
    OnTimeout(now, events);
  }
  if (state_ != State::kAsking || now < send_after_) return {};
  for (; step_ < ZXtremeSteps().size(); ++step_) {
    const ZXtremeCommand command = MakeCommand(step(), config_, data_port_);
    if (command.empty()) continue;
    ++try_;
    waiting_ = true;
    deadline_ = now + config_.reply_timeout;
    return command;
  }
  Finish(now, events);
  return {};
}

void ZXtremeDialogue::OnTimeout(core::MonoTime now, core::Events& events) {
  waiting_ = false;
  if (try_ < config_.tries) return;  // Poll sends it again
  ++silent_steps_;
  const bool probing = !alive_ && step_ + 1 < kProbeSteps;
  if (!alive_ && !probing) {
    state_ = State::kGeneric;
    core::EventText text(
        "no answer to $PASHQ,RID and $PASHQ,PRT: taken for a plain NMEA receiver, ");
    text.Append(
        "nothing was set up; if it is an Ashtech, check our transmit line and its baud rate");
    events.WarnLow(now, "gps.setup.generic", text);
    return;
  }
  if (alive_) {
    core::FixedText<96> what("did not answer in ");
    what.Append(config_.tries).Append(" tries of ");
    FailStep(now, what.Append(core::ToSeconds(config_.reply_timeout), 1).Append(" s").view(),
             events);
  }
  if (alive_ && silent_steps_ >= kSilentSteps) {
    state_ = State::kPartly;
    core::EventText text("receiver fell silent during its set-up at ");
    events.WarnHigh(now, "gps.setup.silent", text.Append(step().command));
    return;
  }
  NextStep(now);
}

/// "$PASHS,NME,GST,A,ON*6C": receiver refused (NAK); accuracy then comes from ...
void ZXtremeDialogue::FailStep(core::MonoTime now, std::string_view what, core::Events& events) {
  ++failed_;
  const ZXtremeCommand command = MakeCommand(step(), config_, data_port_);
  core::EventText text(Shown(command));
  text.Append(": receiver ").Append(what);
  if (!said_.empty()) text.Append(" \"").Append(said_.view()).Append("\"");
  events.WarnLow(now, step().event, text.Append("; ").Append(step().hint));
}

void ZXtremeDialogue::NextStep(core::MonoTime now) {
  if (try_ > 1) send_after_ = now + config_.reply_timeout / 2;
  waiting_ = false;
  try_ = 0;
  said_ = {};
  ++step_;
}

void ZXtremeDialogue::Finish(core::MonoTime now, core::Events& events) {
  state_ = failed_ == 0 ? State::kConfigured : State::kPartly;
  core::EventText text("receiver set up as RTK rover on port ");
  text.Append(std::string_view(&data_port_, 1)).Append(", corrections on port ");
  text.Append(std::string_view(&config_.rtcm_port, 1));
  if (failed_ == 0) {
    events.Info(now, "gps.setup.done", text);
  } else {
    text.Append("; commands that failed: ").Append(failed_);
    events.WarnLow(now, "gps.setup.done", text);
  }
}

}  // namespace kawara::drivers
