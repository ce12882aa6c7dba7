#include "onboard/ahrs_chain.hpp"

namespace kawara::onboard {
namespace {

drivers::Ahrs400Config DecoderConfig(const AhrsConfig& config) {
  drivers::Ahrs400Config decoder;
  decoder.scaling = config.model == 200
                        ? drivers::Ahrs400Scaling::Model200(config.acceleration_sign)
                        : drivers::Ahrs400Scaling::Model100(config.acceleration_sign);
  decoder.mode =
      config.mode == "scaled" ? drivers::Ahrs400Mode::kScaled : drivers::Ahrs400Mode::kAngle;
  decoder.byte_time = core::Nanoseconds(10'000'000'000LL / config.baud_bps);
  return decoder;
}

drivers::Ahrs400DialogueConfig DialogueConfig(const AhrsConfig& config) {
  drivers::Ahrs400DialogueConfig dialogue;
  dialogue.mode = DecoderConfig(config).mode;
  dialogue.model_suffix = config.model;
  // The configured rate first, then the others in their order.
  std::array<int, 6> rates{config.baud_bps};
  std::size_t n = 1;
  for (const int rate : drivers::Ahrs400DialogueConfig{}.baud_rates) {
    if (rate != 0 && rate != config.baud_bps && n < rates.size()) rates[n++] = rate;
  }
  dialogue.baud_rates = rates;
  return dialogue;
}

}  // namespace

AhrsChain::AhrsChain(const AhrsConfig& config, core::Events& events, CoreSink& out,
                     AhrsListener& listener)
    : events_(events),
      out_(out),
      listener_(listener),
      decoder_(DecoderConfig(config)),
      dialogue_(DialogueConfig(config)) {}

void AhrsChain::OnPort(core::MonoTime now, bool opened) {
  now_ = now;
  port_open_ = opened;
  decoder_.Finish(*this);
  decoder_.Reset();
  if (opened) {
    dialogue_.Start(now);
    PumpDialogue();
  } else {
    dialogue_.Stop();
  }
}

void AhrsChain::OnBytes(core::MonoTime arrival, std::span<const std::uint8_t> bytes) {
  now_ = arrival;
  dialogue_.OnBytes(arrival, bytes);
  decoder_.Feed(arrival, bytes, *this);
  PumpDialogue();
}

void AhrsChain::Tick(core::MonoTime now) {
  now_ = now;
  if (!port_open_) return;
  dialogue_.Tick(now);
  PumpDialogue();
}

void AhrsChain::OnSample(const core::AhrsSample& sample, drivers::Ahrs400Mode mode) {
  dialogue_.OnPacket(now_, mode, &sample);
  listener_.OnAhrsSample(sample);
}

void AhrsChain::OnVoltages(const drivers::Ahrs400Voltages& /*voltages*/) {
  dialogue_.OnPacket(now_, drivers::Ahrs400Mode::kVoltage, nullptr);
}

void AhrsChain::OnFrozen(core::MonoTime /*arrival*/, drivers::Ahrs400Mode /*mode*/) {
  dialogue_.OnFrozen();
  events_.WarnHigh(now_, "ahrs.frozen",
                   "the unit repeats the same packet: its sensors stand still");
}

void AhrsChain::PumpDialogue() {
  drivers::Ahrs400Action action;
  while (dialogue_.TryPopAction(action)) {
    switch (action.kind) {
      case drivers::Ahrs400Action::Kind::kWrite:
        out_.Write(PortId::kAhrs, {&action.byte, 1});
        break;
      case drivers::Ahrs400Action::Kind::kSetBaud:
        out_.SetBaud(PortId::kAhrs, action.baud_bps);
        break;
      case drivers::Ahrs400Action::Kind::kEvent:
        events_.Push(now_, action.severity, action.name, action.text);
        break;
    }
  }
}

}  // namespace kawara::onboard
