#include "drivers/ahrs400_dialogue.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::drivers {
namespace {

// Commands and the replies they bring, all one byte. Sources: ahrs400_packet.hpp.
constexpr std::uint8_t kPing = 'R', kPong = 'H';
constexpr std::uint8_t kPolled = 'P';      // no reply; stops the stream
constexpr std::uint8_t kContinuous = 'C';  // no reply; packets follow
constexpr std::uint8_t kGetPacket = 'G';   // one packet; stops the stream, too
constexpr std::uint8_t kGetVersion = 'v';
constexpr std::uint8_t kGetSerial = 'S';

struct ModeBytes {
  std::uint8_t command;
  std::uint8_t reply;
};
constexpr ModeBytes BytesOf(Ahrs400Mode mode) {
  switch (mode) {
    case Ahrs400Mode::kAngle:
      return {'a', 'A'};
    case Ahrs400Mode::kScaled:
      return {'c', 'C'};
    case Ahrs400Mode::kVoltage:
      return {'r', 'R'};
  }
  return {'a', 'A'};
}

/// Fewer bytes may be a glitch of the cable; one angle packet has 30.
constexpr std::uint64_t kBytesThatMeanTalk = 32;
/// About two seconds of level samples decide about the sign of the accelerations.
constexpr int kLevelSamples = 120;

}  // namespace

Ahrs400Dialogue::Ahrs400Dialogue(const Ahrs400DialogueConfig& config) : config_(config) {}

void Ahrs400Dialogue::Start(core::MonoTime now) {
  bytes_at_baud_ = packets_at_baud_ = 0;
  stop_rounds_ = 0;
  announced_ = false;
  last_byte_ = now;
  Enter(now, State::kStop);
}

void Ahrs400Dialogue::Stop() {
  state_ = State::kIdle;
  actions_count_ = 0;
}

void Ahrs400Dialogue::Enter(core::MonoTime now, State state) {
  state_ = state;
  attempt_ = 0;
  Command(now);
}

/// Sends what this state sends, as a new attempt.
void Ahrs400Dialogue::Command(core::MonoTime now) {
  ++attempt_;
  entered_ = now;
  reply_size_ = 0;
  reply_too_long_ = false;
  switch (state_) {
    case State::kIdle:
    case State::kRunning:
      break;
    case State::kStop:
      // 'G' also ends the stream, at the price of one more packet: for units that overheard 'P'.
      Write(attempt_ % 2 == 1 ? kPolled : kGetPacket);
      break;
    case State::kPing:
      Write(kPing);
      break;
    case State::kVersion:
      Write(kGetVersion);
      break;
    case State::kSerial:
      Write(kGetSerial);
      break;
    case State::kMode:
      Write(BytesOf(config_.mode).command);
      break;
    case State::kBegin:
      last_packet_ = now;
      next_poll_ = now + config_.poll_period;
      Write(config_.poll ? kGetPacket : kContinuous);
      break;
  }
}

void Ahrs400Dialogue::OnBytes(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (state_ == State::kIdle || bytes.empty()) return;
  last_byte_ = now;
  bytes_at_baud_ += bytes.size();
  const std::size_t room = reply_.size() - reply_size_;
  const std::size_t n = std::min(room, bytes.size());
  std::copy_n(bytes.begin(), n, reply_.begin() + static_cast<std::ptrdiff_t>(reply_size_));
  reply_size_ += n;
  reply_too_long_ = reply_too_long_ || n < bytes.size();
}

void Ahrs400Dialogue::OnPacket(core::MonoTime now, Ahrs400Mode mode,
                               const core::AhrsSample* sample) {
  ++packets_at_baud_;
  if (state_ != State::kBegin && state_ != State::kRunning) return;
  if (mode != config_.mode) {
    if (state_ == State::kBegin) return;  // an old one on its way
    core::EventText text("AHRS sends ");
    text.Append(ToString(mode)).Append(" packets instead of ").Append(ToString(config_.mode));
    Say(core::Severity::kWarnLow, "ahrs.mode", text.Append(": setting it up again"));
    ++restarts_;
    Start(now);
    return;
  }
  last_packet_ = now;
  if (state_ == State::kBegin) {
    state_ = State::kRunning;
    if (!announced_) {
      announced_ = true;
      core::EventText text("AHRS runs: ");
      text.Append(ToString(config_.mode))
          .Append(config_.poll ? " packets on request at " : " packets at ");
      text.Append(baud_bps()).Append(" baud");
      if (!version_.empty()) text.Append(", ").Append(version_.view());
      if (serial_) text.Append(", serial number ").Append(*serial_);
      Say(core::Severity::kInfo, "ahrs.running", text);
    }
  }
  if (sample != nullptr) CheckSign(*sample);
}

void Ahrs400Dialogue::Tick(core::MonoTime now) {
  switch (state_) {
    case State::kIdle:
      return;
    case State::kStop:
      return TickStop(now);
    case State::kBegin:
    case State::kRunning:
      return TickRunning(now);
    case State::kPing:
    case State::kVersion:
    case State::kSerial:
    case State::kMode:
      break;
  }
  // A reply stands alone: judge it when the line has been quiet after it.
  if (reply_size_ > 0 && now - last_byte_ >= config_.quiet) {
    OnReply(now);
  } else if (now - entered_ > config_.reply_timeout && now - last_byte_ >= config_.quiet) {
    OnTimeout(now);
  } else if (now - entered_ > 2 * config_.reply_timeout) {
    OnTimeout(now);  // it never becomes quiet
  }
}

void Ahrs400Dialogue::TickStop(core::MonoTime now) {
  if (now - last_byte_ >= config_.quiet && now - entered_ >= config_.quiet) {
    Enter(now, State::kPing);
    return;
  }
  if (now - entered_ < config_.stop_timeout) return;
  if (attempt_ < 2 * config_.attempts) {
    Command(now);
    return;
  }
  if (packets_at_baud_ > 0) {
    // It talks sense but does not listen: our line to it is cut. Take what it sends, if it is the
    // right kind.
    core::EventText text("AHRS streams but takes no command (is the wire to it connected?)");
    Say(core::Severity::kWarnHigh, "ahrs.deaf", text);
    last_packet_ = now;
    announced_ = true;
    state_ = State::kBegin;
    attempt_ = config_.attempts;
    return;
  }
  NextBaud(now);
}

void Ahrs400Dialogue::OnReply(core::MonoTime now) {
  // A slow unit may answer several attempts at once: the reply proper is what stands last.
  const std::span<const std::uint8_t> all(reply_.data(), reply_size_);
  const auto last = [&](std::size_t n) { return all.last(std::min(n, all.size())); };
  const auto is_byte = [&](std::uint8_t byte) {
    return all.back() == byte && all.size() <= static_cast<std::size_t>(config_.attempts);
  };
  bool fits = false;
  State next = State::kPing;
  switch (state_) {
    case State::kPing:
      fits = is_byte(kPong);
      next = State::kVersion;
      break;
    case State::kVersion:
      fits = !reply_too_long_ && IsAhrs400Version(last(kAhrs400VersionBytes));
      if (fits) TakeVersion(last(kAhrs400VersionBytes));
      next = State::kSerial;
      break;
    case State::kSerial:
      fits = !reply_too_long_ && all.size() >= kAhrs400SerialBytes &&
             Ahrs400FrameFits(last(kAhrs400SerialBytes));
      if (fits) {
        const auto frame = last(kAhrs400SerialBytes);
        serial_ = static_cast<std::uint32_t>(frame[1]) << 24 |
                  static_cast<std::uint32_t>(frame[2]) << 16 |
                  static_cast<std::uint32_t>(frame[3]) << 8 | frame[4];
      }
      next = State::kMode;
      break;
    case State::kMode:
      fits = is_byte(BytesOf(config_.mode).reply);
      next = State::kBegin;
      break;
    default:
      return;
  }
  if (fits) {
    Enter(now, next);
  } else {
    OnTimeout(now);
  }
}

void Ahrs400Dialogue::OnTimeout(core::MonoTime now) {
  if (attempt_ < config_.attempts) {
    Command(now);
    return;
  }
  switch (state_) {
    case State::kVersion:
      Say(core::Severity::kWarnLow, "ahrs.version",
          "AHRS does not tell its version: whether its scaling is as configured stays unchecked");
      Enter(now, State::kSerial);
      return;
    case State::kSerial:
      Enter(now, State::kMode);
      return;
    case State::kMode:
      if (stop_rounds_++ == 0) {
        Enter(now, State::kStop);  // perhaps it was not quite quiet
        return;
      }
      break;
    default:
      break;
  }
  NextBaud(now);
}

void Ahrs400Dialogue::TickRunning(core::MonoTime now) {
  if (config_.poll && now >= next_poll_) {
    Write(kGetPacket);
    next_poll_ = std::max(next_poll_ + config_.poll_period, now);
  }
  if (now - last_packet_ <= config_.stall) return;
  ++restarts_;
  if (state_ == State::kRunning) {
    core::EventText text("AHRS: no packet for ");
    text.Append(core::ToSeconds(now - last_packet_), 1).Append(" s, ");
    text.Append(now - last_byte_ > config_.stall ? "the line is silent"
                                                 : "bytes come, but no new packet in them");
    Say(core::Severity::kWarnHigh, "ahrs.stalled", text.Append(": setting it up again"));
  }
  Start(now);
}

void Ahrs400Dialogue::NextBaud(core::MonoTime now) {
  core::EventText text("AHRS: ");
  const bool talk = bytes_at_baud_ >= kBytesThatMeanTalk;
  if (talk) {
    text.Append(bytes_at_baud_).Append(" bytes at ").Append(baud_bps());
    text.Append(" baud, but none fit a packet or a reply: wrong baud rate, or another device");
  } else {
    text.Append("no answer at ").Append(baud_bps()).Append(" baud (switched on? cable?)");
  }
  std::size_t rates = 0;
  while (rates < config_.baud_rates.size() && config_.baud_rates[rates] > 0) ++rates;
  bool all_tried = false;
  if (talk || baud_index_ == 0) {
    all_tried = next_other_ + 1 >= rates;
    next_other_ = all_tried ? 0 : next_other_ + 1;
    baud_index_ = next_other_;
  } else {
    // A silent unit is most likely switched off: be at its usual rate every other time.
    baud_index_ = 0;
  }
  if (all_tried) {
    text.Append("; tried ");
    for (std::size_t i = 0; i < rates; ++i) {
      text.Append(i == 0 ? "" : ", ").Append(config_.baud_rates[i]);
    }
    text.Append(", beginning again");
  }
  text.Append("; now ").Append(baud_bps());
  Say(talk || all_tried ? core::Severity::kWarnHigh : core::Severity::kWarnLow, "ahrs.baud", text);
  Ahrs400Action action;
  action.kind = Ahrs400Action::Kind::kSetBaud;
  action.baud_bps = baud_bps();
  PushAction(action);
  Start(now);
}

void Ahrs400Dialogue::TakeVersion(std::span<const std::uint8_t> frame) {
  std::span<const std::uint8_t> text = frame.subspan(1, frame.size() - 2);
  while (!text.empty() && text.back() == ' ') text = text.first(text.size() - 1);
  version_ = {};
  for (const std::uint8_t c : text) {
    const char character = static_cast<char>(c);
    version_.Append(std::string_view(&character, 1));
  }
  const int suffix = Ahrs400ModelSuffix(version_.view());
  if (suffix != 0 && suffix != config_.model_suffix) {
    core::EventText warning("AHRS says it is ");
    warning.Append(version_.view())
        .Append(", but the configured scaling is -")
        .Append(config_.model_suffix);
    warning.Append(": rates and accelerations come out wrong by a factor 2; set the scaling to ")
        .Append(suffix);
    Say(core::Severity::kWarnHigh, "ahrs.scaling", warning);
  }
}

/// Level and at rest, or nearly: gravity must show as -9.8 on z, whatever the unit's own idea of a
/// sign.
void Ahrs400Dialogue::CheckSign(const core::AhrsSample& sample) {
  if (sign_checked_ || !sample.has_attitude) return;
  constexpr double kLevelRad = 0.35;
  if (std::abs(sample.attitude.roll_rad) > kLevelRad ||
      std::abs(sample.attitude.pitch_rad) > kLevelRad) {
    return;
  }
  ++level_samples_;
  if (sample.specific_force_mps2.z() > 0.0) ++level_upside_down_;
  if (level_samples_ < kLevelSamples) return;
  sign_checked_ = true;
  if (level_upside_down_ > kLevelSamples * 9 / 10) {
    Say(core::Severity::kWarnHigh, "ahrs.acceleration_sign",
        "AHRS: level by its angles, but z acceleration is positive: reverse the configured "
        "acceleration sign");
  }
}

void Ahrs400Dialogue::Write(std::uint8_t byte) {
  Ahrs400Action action;
  action.kind = Ahrs400Action::Kind::kWrite;
  action.byte = byte;
  PushAction(action);
}

void Ahrs400Dialogue::Say(core::Severity severity, const char* name, const core::EventText& text) {
  Ahrs400Action action;
  action.kind = Ahrs400Action::Kind::kEvent;
  action.severity = severity;
  action.name = name;
  action.text = text;
  PushAction(action);
}

void Ahrs400Dialogue::PushAction(const Ahrs400Action& action) {
  if (actions_count_ == actions_.size()) {  // the owner does not look: the oldest gives way
    actions_head_ = (actions_head_ + 1) % actions_.size();
    --actions_count_;
  }
  actions_[(actions_head_ + actions_count_) % actions_.size()] = action;
  ++actions_count_;
}

bool Ahrs400Dialogue::TryPopAction(Ahrs400Action& out) {
  if (actions_count_ == 0) return false;
  out = actions_[actions_head_];
  actions_head_ = (actions_head_ + 1) % actions_.size();
  --actions_count_;
  return true;
}

}  // namespace kawara::drivers
