#include "sim/instruments/sick_scanner.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "drivers/sick_telegram.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kTurn = core::Milliseconds(40);
constexpr core::Duration kQuarterTurn = core::Milliseconds(10);
/// A telegram that stops in its middle is forgotten after this.
constexpr core::Duration kInputTimeout = core::Milliseconds(100);
constexpr std::uint8_t kFromScanner = 0x80;
constexpr std::uint8_t kStatusGood = 0x10;
constexpr std::uint8_t kNotAccepted = 0x92;
constexpr std::uint8_t kDone = 0x00;
constexpr std::uint8_t kImpossible = 0x01;
constexpr std::uint16_t kNothing = 0x1FFF;  ///< no echo: the most that 13 bits hold
constexpr std::string_view kVersion = "V02.02 ";
constexpr std::string_view kType = "PLS101-312;V02.02 ";
constexpr std::string_view kGreeting = "PLS101-312;V02.02 SIM";  ///< telegram of 29 bytes

void PutWord(std::vector<std::uint8_t>& out, std::size_t word) {
  out.push_back(static_cast<std::uint8_t>(word & 0xFFU));
  out.push_back(static_cast<std::uint8_t>(word >> 8));
}
void PutText(std::vector<std::uint8_t>& out, std::string_view text) {
  for (const char c : text) out.push_back(static_cast<std::uint8_t>(c));
}
std::size_t Word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] | (std::size_t{bytes[at + 1]} << 8);
}

}  // namespace

SickScanner::SickScanner(RangeCaster caster, const SimClock& clock, core::GpsTime begin,
                         core::GpsTime end, const SickScannerOptions& options)
    : caster_(std::move(caster)),
      clock_(clock),
      begin_(begin),
      end_(end),
      options_(options),
      transmitter_(options.baud_bps, 4096, options.bits_per_byte),
      dice_(options.seed) {}

void SickScanner::Boot(core::MonoTime now) {
  mode_ = Mode::kRequest;
  one_scan_wanted_ = false;
  reply_.reset();
  input_.clear();
  transmitter_.SetBaud(options_.baud_bps);
  wakes_at_ = now + core::DurationFromSeconds(options_.boot_s);
}

void SickScanner::SetPower(core::MonoTime now, bool on) {
  if (on && !powered_) Boot(now);
  if (!on && powered_) {
    transmitter_.Clear();
    reply_.reset();
    wakes_at_ = {};
  }
  powered_ = on;
}

void SickScanner::Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (!powered_ || wakes_at_.IsSet()) return;
  if (now - last_input_ > kInputTimeout) input_.clear();
  last_input_ = now;
  for (const std::uint8_t byte : bytes) TakeByte(now, byte);
}

void SickScanner::TakeByte(core::MonoTime now, std::uint8_t byte) {
  if (input_.empty() && byte != drivers::kSickStx) return;
  input_.push_back(byte);
  if (input_.size() < 4) return;
  const std::size_t length = Word(input_, 2);
  if (length == 0 || length > drivers::kSickMaxLength) {
    input_.clear();
    return;
  }
  if (input_.size() < length + drivers::kSickOverheadBytes) return;
  const std::vector<std::uint8_t> telegram = std::exchange(input_, {});
  if (telegram[1] != options_.address) return;  // to another one on the line
  ++counters_.telegrams_in;
  const std::size_t body = 4 + length;
  if (drivers::SickCrc(std::span(telegram).first(body)) != Word(telegram, body) || reply_) {
    ++counters_.refused;
    SendByte(now, drivers::kSickNak);
    return;
  }
  Obey(now, std::span(telegram).subspan(4, length));
}

void SickScanner::Obey(core::MonoTime now, std::span<const std::uint8_t> payload) {
  switch (payload[0]) {
    case 0x10:
      SendByte(now, drivers::kSickAck);
      reply_ = Reply{now, {0x91}, 0, true};
      break;
    case 0x20:
      if (payload.size() < 2) return Refuse(now);
      ObeyMode(now, payload);
      break;
    case 0x30:
      if (payload.size() != 2 || payload[1] != 0x01 || mode_ == Mode::kInstall) return Refuse(now);
      SendByte(now, drivers::kSickAck);
      one_scan_wanted_ = true;
      break;
    case 0x31: {
      SendByte(now, drivers::kSickAck);
      Reply reply{now, {0xB1}};
      PutText(reply.payload, kVersion);
      reply.payload.push_back(static_cast<std::uint8_t>(mode_));
      reply_ = std::move(reply);
      break;
    }
    case 0x3A: {
      SendByte(now, drivers::kSickAck);
      Reply reply{now, {0xBA}};
      PutText(reply.payload, kType);
      reply_ = std::move(reply);
      break;
    }
    default:
      Refuse(now);
  }
}

void SickScanner::ObeyMode(core::MonoTime now, std::span<const std::uint8_t> payload) {
  SendByte(now, drivers::kSickAck);
  const core::MonoTime later = now + core::DurationFromSeconds(options_.mode_change_s);
  Reply reply{later, {0xA0, kDone}};
  switch (payload[1]) {
    case 0x00: {
      const bool right = std::equal(
          payload.begin() + 2, payload.end(), options_.password.begin(), options_.password.end(),
          [](std::uint8_t byte, char c) { return byte == static_cast<std::uint8_t>(c); });
      if (right) mode_ = Mode::kInstall;
      if (!right) reply.payload[1] = kImpossible;
      break;
    }
    case 0x24:
      mode_ = Mode::kStream;
      break;
    case 0x25:
      mode_ = Mode::kRequest;
      break;
    case 0x27:
      if (!ObeyPart(payload)) reply.payload[1] = kImpossible;
      break;
    case 0x40:
      reply.new_baud_bps = 38400;
      break;
    case 0x41:
      reply.new_baud_bps = 19200;
      break;
    case 0x42:
      reply.new_baud_bps = 9600;
      break;
    case 0x48:
      if (options_.fast_line) reply.new_baud_bps = 500000;
      if (!options_.fast_line) reply.payload[1] = kImpossible;
      break;
    default:
      reply.payload[1] = kImpossible;
  }
  // Some hosts change their rate at the ACK: the reply does not keep them waiting.
  if (reply.new_baud_bps != 0) reply.at = now;
  if (reply.payload[1] != kDone) ++counters_.refused;
  reply_ = std::move(reply);
}

bool SickScanner::ObeyPart(std::span<const std::uint8_t> payload) {
  if (payload.size() != 6) return false;
  const std::size_t first = Word(payload, 2);
  const std::size_t last = Word(payload, 4);
  if (first < 1 || last < first || last > kPlsPoints) return false;
  first_ = first;
  last_ = last;
  mode_ = Mode::kStreamPart;
  return true;
}

void SickScanner::Refuse(core::MonoTime now) {
  ++counters_.refused;
  SendByte(now, drivers::kSickNak);
  reply_ = Reply{now, {kNotAccepted}};
}

void SickScanner::SendByte(core::MonoTime now, std::uint8_t byte) {
  transmitter_.Send(now, {&byte, 1});
}

void SickScanner::SendTelegram(core::MonoTime at, std::vector<std::uint8_t> payload) {
  payload.push_back(kStatusGood);
  std::vector<std::uint8_t> telegram{drivers::kSickStx,
                                     static_cast<std::uint8_t>(options_.address | kFromScanner)};
  PutWord(telegram, payload.size());
  telegram.insert(telegram.end(), payload.begin(), payload.end());
  PutWord(telegram, drivers::SickCrc(telegram));
  transmitter_.Send(at, telegram);
}

void SickScanner::SendReply() {
  Reply reply = std::move(*reply_);
  reply_.reset();
  SendTelegram(reply.at, std::move(reply.payload));
  if (reply.new_baud_bps != 0) transmitter_.SetBaud(reply.new_baud_bps);
  if (reply.reboot) Boot(transmitter_.FreeAt(reply.at));
}

void SickScanner::SendScan(core::MonoTime at, core::GpsTime ahead) {
  std::fill(ranges_m_.begin(), ranges_m_.end(), INFINITY);
  if (caster_) caster_(ahead, ranges_m_);
  const bool part = mode_ == Mode::kStreamPart && !one_scan_wanted_;
  const std::size_t first = part ? first_ : 1;
  const std::size_t last = part ? last_ : kPlsPoints;
  std::vector<std::uint8_t> payload{static_cast<std::uint8_t>(part ? 0xB7 : 0xB0)};
  if (part) {
    PutWord(payload, first);
    PutWord(payload, last);
  }
  PutWord(payload, last - first + 1);  // upper bits 0: centimetres
  for (std::size_t i = 0; i < kPlsPoints; ++i) {
    const double noise_m = options_.range_noise_m * dice_.Normal();
    if (i + 1 < first || i + 1 > last) continue;
    const double range_m = static_cast<double>(ranges_m_[i]);
    std::size_t word = kNothing;
    if (range_m <= kPlsMaxRange_m) {  // not so for NaN
      word = static_cast<std::size_t>(
          std::lround(100.0 * std::max(range_m + noise_m, options_.blind_m)));
    }
    PutWord(payload, word);
  }
  SendTelegram(at, std::move(payload));
  ++counters_.scans;
  one_scan_wanted_ = false;
}

core::GpsTime SickScanner::AheadOfTurn(std::int64_t turn) const {
  const double turns_s =
      static_cast<double>(turn) * core::ToSeconds(kTurn) / (1.0 + options_.mirror_skew_ppm * 1e-6);
  return begin_ + kQuarterTurn + core::DurationFromSeconds(turns_s);
}

core::MonoTime SickScanner::OutputOfTurn(std::int64_t turn) const {
  return clock_.MonoAt(AheadOfTurn(turn) + kQuarterTurn +
                       core::DurationFromSeconds(options_.output_delay_s));
}

void SickScanner::Advance(core::MonoTime now) {
  if (wakes_at_.IsSet() && wakes_at_ <= now) {
    std::vector<std::uint8_t> greeting{0x90};
    PutText(greeting, kGreeting);
    SendTelegram(std::exchange(wakes_at_, {}), std::move(greeting));
  }
  for (;; ++next_turn_) {
    const core::MonoTime at = OutputOfTurn(next_turn_);
    const bool over = AheadOfTurn(next_turn_) > end_;
    if (reply_ && reply_->at <= now && (over || reply_->at <= at)) SendReply();
    if (over || at > now) break;
    ++counters_.turns;
    const bool awake = powered_ && !wakes_at_.IsSet() && !reply_;
    if (!awake || !(Streaming() || one_scan_wanted_)) continue;
    if (transmitter_.FreeAt(at) > at) continue;
    SendScan(at, AheadOfTurn(next_turn_));
  }
}

core::MonoTime SickScanner::NextEvent() const {
  core::MonoTime next;
  const auto consider = [&next](core::MonoTime t) {
    if (!next.IsSet() || t < next) next = t;
  };
  if (wakes_at_.IsSet()) consider(wakes_at_);
  if (reply_) consider(reply_->at);
  if ((Streaming() || one_scan_wanted_) && AheadOfTurn(next_turn_) <= end_)
    consider(OutputOfTurn(next_turn_));
  return next;
}

}  // namespace kawara::sim
