#include "onboard/gps_chain.hpp"

namespace kawara::onboard {
namespace {

constexpr core::Duration kSilence = core::Seconds(3);
constexpr core::Duration kNoFix = core::Seconds(30);
constexpr core::Duration kBaudPatience = core::Milliseconds(3500);
/// From the SPD command to our own change of rate: the command must have left the UART and been
/// obeyed.
constexpr core::Duration kSpeedUpDelay = core::Milliseconds(300);
/// The lowest date a receiver can honestly send: before the last GPS week roll-over it has lost
/// 1024 weeks.
constexpr core::CivilTime kNotBefore{2019, 4, 7};

drivers::GnssEpochConfig EpochConfig(const GpsConfig& config, core::UtcTime reference) {
  drivers::GnssEpochConfig epoch;
  if (!drivers::FromString(config.profile, epoch.profile)) {
    epoch.profile = drivers::ReceiverProfile::kNmea;
  }
  epoch.reference = reference;
  epoch.not_before = core::FromCivil(kNotBefore);
  return epoch;
}

drivers::ZXtremeConfig DialogueConfig(const GpsConfig& config) {
  drivers::ZXtremeConfig dialogue;
  dialogue.data_port = config.data_port[0];
  dialogue.rtcm_port = config.correction_port[0];
  dialogue.period_s = config.period_s;
  dialogue.save = config.save;
  return dialogue;
}

}  // namespace

GpsChain::GpsChain(const GpsConfig& config, core::Events& events, CoreSink& out,
                   GpsListener& listener)
    : config_(config),
      events_(events),
      out_(out),
      listener_(listener),
      assembler_(EpochConfig(config, {})),
      dialogue_(DialogueConfig(config)),
      baud_(config.baud_bps, kBaudPatience) {}

void GpsChain::SetReference(core::UtcTime utc) {
  if (has_reference_) return;
  has_reference_ = true;
  assembler_ = drivers::GnssEpochAssembler(EpochConfig(config_, utc));
}

void GpsChain::OnPort(core::MonoTime now, bool opened) {
  now_ = now;
  port_open_ = opened;
  speed_up_at_ = {};
  decoder_.Finish(*this);
  if (!opened) return;
  opened_at_ = last_message_ = last_position_ = now;
  baud_.Start(now);
  if (config_.configure) dialogue_.Start(now);
}

void GpsChain::OnBytes(core::MonoTime arrival, std::span<const std::uint8_t> bytes) {
  now_ = arrival;
  baud_.OnBytes(bytes.size());
  decoder_.Feed(arrival, bytes, *this);
  PumpDialogue();
}

void GpsChain::Tick(core::MonoTime now) {
  now_ = now;
  assembler_.Tick(now, *this);
  if (!port_open_) return;
  PumpDialogue();
  FindBaud();
  CheckHealth();
}

bool GpsChain::corrections_allowed() const {
  return port_open_ && (!config_.configure || dialogue_.corrections_allowed());
}

void GpsChain::OnMessage(const drivers::GnssMessage& message) {
  last_message_ = now_;
  if (!baud_.found()) {
    baud_.OnMessage();
    SpeedUp();
  }
  if (config_.configure) dialogue_.OnMessage(now_, message, events_);
  if (const auto* tag = message.Ashtech<drivers::AshtechTimeTag>()) {
    listener_.OnTimeTag(*tag, message.arrival);
  }
  assembler_.OnMessage(message, *this);
}

void GpsChain::OnFix(const core::GnssFix& fix) {
  if (fix.has_position) last_position_ = now_;
  if (fix.rtk != last_rtk_) {
    core::EventText text("RTK state ");
    text.Append(core::ToString(last_rtk_)).Append(" -> ").Append(core::ToString(fix.rtk));
    const bool worse = fix.rtk < last_rtk_;
    events_.Push(now_, worse ? core::Severity::kWarnLow : core::Severity::kInfo, "gps.rtk_state",
                 text);
    last_rtk_ = fix.rtk;
  }
  out_.OnFix(fix);
  listener_.OnGpsFix(fix);
}

void GpsChain::PumpDialogue() {
  if (!config_.configure || !port_open_ || speed_up_at_.IsSet()) return;
  for (int i = 0; i < 4; ++i) {
    const auto command = dialogue_.Poll(now_, events_);
    if (command.empty()) return;
    const std::string_view text = command.view();
    out_.Write(PortId::kGps, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
}

/// The receiver was found at another rate than the configured one: brings it to ours.
void GpsChain::SpeedUp() {
  if (baud_.current() == baud_.configured()) return;
  core::EventText text("the receiver speaks ");
  text.Append(baud_.current()).Append(" baud, not the configured ").Append(baud_.configured());
  const int code = drivers::AshtechBaudCode(baud_.configured());
  if (!config_.configure || code < 0) {
    text.Append(": staying at its rate; mend gps.baud_bps");
    events_.WarnLow(now_, "gps.baud", text);
    return;
  }
  events_.WarnLow(now_, "gps.baud", text.Append(": telling it to change"));
  core::FixedText<48> command("$PASHS,SPD,");
  command.Append(config_.data_port).Append(",").Append(code).Append("\r\n");
  const std::string_view bytes = command.view();
  out_.Write(PortId::kGps, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  speed_up_at_ = now_ + kSpeedUpDelay;
}

void GpsChain::FindBaud() {
  if (speed_up_at_.IsSet()) {
    if (now_ < speed_up_at_) return;
    speed_up_at_ = {};
    baud_ = BaudFinder(config_.baud_bps, kBaudPatience);
    baud_.Start(now_);
    out_.SetBaud(PortId::kGps, config_.baud_bps);
    dialogue_.Start(now_);
    return;
  }
  const int tried = baud_.current();
  const std::size_t bytes = baud_.bytes_without_message();
  if (baud_.Tick(now_, config_.configure) == BaudFinder::Advice::kStay) return;
  core::EventText text;
  if (bytes > 0) {
    text.Append(bytes).Append(" bytes and no message at ").Append(tried);
  } else {
    text.Append("no answer at ").Append(tried);
  }
  text.Append(" baud: wrong rate? Trying ").Append(baud_.current());
  if (baud_.exhausted()) text.Append(" (all usual rates were tried: cable, port or receiver?)");
  events_.WarnHigh(now_, "gps.no_message", text);
  out_.SetBaud(PortId::kGps, baud_.current());
  if (config_.configure) dialogue_.Start(now_);
}

void GpsChain::CheckHealth() {
  if (baud_.found() && now_ - last_message_ > kSilence) {
    core::EventText text("nothing from the receiver for ");
    events_.WarnHigh(now_, "gps.silent",
                     text.Append(core::ToSeconds(now_ - last_message_), 0).Append(" s"));
    last_rtk_ = core::RtkState::kNone;
    // It may have been switched off and on and forgotten its set-up and its rate.
    if (config_.configure) {
      last_message_ = now_;
      baud_.Start(now_);
      dialogue_.Start(now_);
    }
    return;
  }
  if (now_ - last_position_ > kNoFix) {
    core::EventText text("the receiver sends, but has had no position for ");
    events_.WarnHigh(now_, "gps.no_fix",
                     text.Append(core::ToSeconds(now_ - last_position_), 0)
                         .Append(" s: antenna, sky? Pictures go out without a place"));
  }
}

}  // namespace kawara::onboard
