#include "sim/instruments/gps_receiver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kawara::sim {
namespace {

constexpr std::size_t kLongestCommand = 128;
/// Epochs of the recording lie a millisecond before the quarter second; periods count from full
/// seconds.
constexpr core::Duration kEpochTolerance = core::Milliseconds(5);
/// Pulse to $PASHR,PTT and $PASHR,TTT, least. PTT leaves before the burst of an epoch on the
/// second; the manual promises it within 100 ms.
constexpr double kPulseReport_s = 0.010;
constexpr double kWanderTau_s = 60.0;

/// Standard deviation of the wandering error, horizontal per axis and down: ordinary figures for
/// each kind of solution.
struct ErrorSize {
  double horizontal_m;
  double down_m;
};
ErrorSize SizeOf(core::RtkState rtk) {
  switch (rtk) {
    case core::RtkState::kAutonomous:
      return {1.2, 2.5};
    case core::RtkState::kCodeDifferential:
      return {0.5, 1.0};
    case core::RtkState::kFloat:
      return {0.15, 0.25};
    default:
      return {0.0, 0.0};
  }
}

bool CarriesRtcm3Observations(std::span<const std::uint8_t> frame) {
  const std::span<const std::uint8_t> payload = drivers::Rtcm3Payload(frame);
  if (payload.size() < 2) return false;
  const int type = (payload[0] << 4) | (payload[1] >> 4);
  return (type >= 1001 && type <= 1004) || (type >= 1009 && type <= 1012) ||
         (type >= 1071 && type <= 1137);
}
bool CarriesRtcm2Corrections(int type) {
  return type == 1 || type == 9 || (type >= 18 && type <= 21);
}

std::int64_t SlotOf(core::GpsTime t, core::Duration period) {
  return (t + kEpochTolerance).ns() / std::max<std::int64_t>(period.count(), 1);
}

}  // namespace

GpsReceiver::GpsReceiver(const Recording& recording, const SimClock& clock, core::GpsTime begin,
                         core::GpsTime end, const GpsReceiverOptions& options)
    : recording_(recording),
      clock_(clock),
      end_(end),
      options_(options),
      settings_(SavedAtStart()),
      saved_(settings_),
      transmitter_(options.baud_bps),
      dice_(options.seed),
      last_edge_(begin) {
  const auto first =
      std::lower_bound(recording_.fixes.begin(), recording_.fixes.end(), begin,
                       [](const RecordedFix& fix, core::GpsTime t) { return fix.time < t; });
  next_fix_ = static_cast<std::size_t>(first - recording_.fixes.begin());
  ScheduleEpoch();
  ScheduleReportOfPulse(begin);
}

AshtechSettings GpsReceiver::SavedAtStart() const {
  AshtechSettings s;
  AshtechSettings::Port& port = s.ports[own_port()];
  port.baud_code = AshtechBaudCode(options_.baud_bps).value_or(5);
  if (!options_.streaming) return s;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(AshtechMessage::kTtt); ++i) port.on.set(i);
  s.nmea_period = s.raw_period = core::Milliseconds(100);
  s.corrections_port = static_cast<int>(own_port());
  s.rover = s.cpd_works = true;
  return s;
}

bool GpsReceiver::IsOn(AshtechMessage message) const {
  return settings_.ports[own_port()].on[static_cast<std::size_t>(message)];
}

void GpsReceiver::ScheduleEpoch() {
  epoch_due_ = core::MonoTime{};
  if (next_fix_ >= recording_.fixes.size() || recording_.fixes[next_fix_].time > end_) return;
  double latency_s = options_.latency_s + options_.latency_jitter_s * dice_.Exponential();
  if (dice_.Uniform() < 0.01) latency_s += 5.0 * options_.latency_jitter_s;
  epoch_latency_ = core::DurationFromSeconds(latency_s);
  epoch_due_ = clock_.MonoAt(recording_.fixes[next_fix_].time) + epoch_latency_;
}

std::optional<core::GpsTime> GpsReceiver::PulseAfter(core::GpsTime after) const {
  if (settings_.pps_period.count() <= 0) return std::nullopt;
  const std::int64_t period = settings_.pps_period.count();
  const std::int64_t k = (after - settings_.pps_offset).ns() / period + 1;
  const core::GpsTime pulse = core::GpsTime::FromNs(k * period) + settings_.pps_offset;
  if (pulse > end_) return std::nullopt;
  return pulse;
}

void GpsReceiver::ScheduleReportOfPulse(core::GpsTime after) {
  pps_.reset();
  const auto pulse = PulseAfter(after);
  if (!pulse) return;
  pps_ = Pulse{
      clock_.MonoAt(*pulse) + core::DurationFromSeconds(kPulseReport_s * (1.0 + dice_.Uniform())),
      *pulse};
}

core::MonoTime GpsReceiver::NextEdge() const {
  const auto pulse = PulseAfter(last_edge_);
  return pulse ? clock_.MonoAt(*pulse) : core::MonoTime{};
}

void GpsReceiver::RaiseEdges(core::MonoTime now) {
  while (const auto pulse = PulseAfter(last_edge_)) {
    const core::MonoTime edge = clock_.MonoAt(*pulse);
    if (edge > now) return;
    last_edge_ = *pulse;
    if (!faults_.power_off) edges_.push_back(edge);
  }
}

void GpsReceiver::SetFaults(const Faults& faults) {
  if (faults.power_off && !faults_.power_off) {
    transmitter_.Clear();
    line_.clear();
  }
  if (!faults.power_off && faults_.power_off) {
    settings_ = saved_;
    transmitter_.SetBaud(AshtechBaud(settings_.ports[own_port()].baud_code));
  }
  faults_ = faults;
}

void GpsReceiver::AddEvent(core::MonoTime pulse) {
  const std::lock_guard lock(pulses_mutex_);
  pulses_.push_back(pulse);
}

void GpsReceiver::TakePulses() {
  std::vector<core::MonoTime> pulses;
  {
    const std::lock_guard lock(pulses_mutex_);
    pulses.swap(pulses_);
  }
  for (const core::MonoTime pulse : pulses) {
    const core::GpsTime time = clock_.GpsAt(pulse);
    const auto after =
        std::upper_bound(recording_.fixes.begin(), recording_.fixes.end(), time,
                         [](core::GpsTime t, const RecordedFix& fix) { return t < fix.time; });
    const auto interval = static_cast<std::size_t>(after - recording_.fixes.begin());
    if (interval == last_event_interval_) {
      ++counters_.events_suppressed;
      continue;
    }
    last_event_interval_ = interval;
    events_.push_back(
        {pulse + core::DurationFromSeconds(kPulseReport_s * (1.0 + dice_.Uniform())), time});
  }
}

void GpsReceiver::Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (faults_.power_off) return;
  TakeCorrections(now, bytes);
  for (const std::uint8_t byte : bytes) TakeByte(now, byte);
}

void GpsReceiver::TakeByte(core::MonoTime now, std::uint8_t byte) {
  if (byte == '$') {
    line_.assign(1, '$');
  } else if (line_.empty()) {
    return;
  } else if (byte == '\r' || byte == '\n') {
    const std::string line = std::exchange(line_, {});
    Obey(now, line);
  } else if (byte < ' ' || byte > '~' || line_.size() >= kLongestCommand) {
    line_.clear();
  } else {
    line_ += static_cast<char>(byte);
  }
}

void GpsReceiver::Obey(core::MonoTime now, std::string_view line) {
  ++counters_.commands;
  const AshtechReply reply = ObeyAshtech(line, static_cast<int>(own_port()), settings_);
  if (reply.text.find(",NAK*") != std::string::npos) ++counters_.refused;
  if (reply.save) saved_ = *reply.save ? settings_ : AshtechSettings{};
  if (!reply.text.empty()) Send(now, reply.text);
  if (reply.once && last_) Send(now, Sentence(*reply.once, *last_));
  transmitter_.SetBaud(AshtechBaud(settings_.ports[own_port()].baud_code));
  ScheduleReportOfPulse(clock_.GpsAt(now));
}

void GpsReceiver::TakeCorrections(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (settings_.corrections_port != static_cast<int>(own_port())) return;
  std::span<const std::uint8_t> rest = bytes;
  while (const auto frame = rtcm3_.Next(rest)) {
    ++counters_.rtcm_messages;
    if (CarriesRtcm3Observations(*frame)) last_corrections_ = now;
  }
  rest = bytes;
  while (const drivers::Rtcm2Message* message = rtcm2_.Next(rest)) {
    ++counters_.rtcm_messages;
    if (CarriesRtcm2Corrections(message->type)) last_corrections_ = now;
  }
}

core::RtkState GpsReceiver::StateNow(core::RtkState recorded, core::MonoTime now) {
  if (faults_.no_fix) return core::RtkState::kNone;
  // Never better than what the recording's sky gave.
  const auto at_best = [&](core::RtkState state) { return std::min(state, recorded); };
  const bool fed =
      last_corrections_.IsSet() && now - last_corrections_ <= settings_.corrections_max_age;
  if (!settings_.cpd_works)
    return at_best(fed ? core::RtkState::kCodeDifferential : core::RtkState::kAutonomous);
  if (!options_.needs_corrections) return recorded;
  if (!fed || now - last_corrections_ > core::DurationFromSeconds(options_.fix_age_s)) {
    // Ambiguities are lost; with new corrections they take their time again.
    fixes_again_ = core::MonoTime{};
    return at_best(fed ? core::RtkState::kFloat : core::RtkState::kAutonomous);
  }
  if (!fixes_again_.IsSet()) fixes_again_ = now + core::DurationFromSeconds(options_.refix_s);
  return now < fixes_again_ ? at_best(core::RtkState::kFloat) : recorded;
}

GpsSolution GpsReceiver::Solve(const RecordedFix& fix, core::MonoTime now) {
  GpsSolution s;
  s.time = TimeTag(fix.time);
  s.rtk = StateNow(fix.rtk, now);
  s.satellites = s.rtk == core::RtkState::kNone ? 0 : fix.satellites;
  s.geoid_m = recording_.site.geoid_m;
  s.velocity_ned_mps = fix.velocity_ned_mps;
  s.velocity_sd_ned_mps = fix.velocity_sd_ned_mps;
  s.latency_ms = static_cast<int>(std::lround(core::ToSeconds(epoch_latency_) * 1e3));
  s.fast_cpd = settings_.fast_cpd;
  if (last_corrections_.IsSet()) s.correction_age_s = core::ToSeconds(now - last_corrections_);

  // The errors wander whether they are used or not, so that a change of state does not restart
  // them.
  const double dt_s = last_ ? core::ToSeconds(fix.time - last_->time) : 1e9;
  const double keep = std::exp(-std::abs(dt_s) / kWanderTau_s);
  for (double& axis : wander_) axis = keep * axis + std::sqrt(1.0 - keep * keep) * dice_.Normal();
  const ErrorSize size = s.rtk == fix.rtk ? ErrorSize{0.0, 0.0} : SizeOf(s.rtk);
  const Eigen::Vector3d sd(size.horizontal_m, size.horizontal_m, size.down_m);
  s.antenna =
      size.down_m > 0.0 ? core::OffsetNed(fix.antenna, wander_.cwiseProduct(sd)) : fix.antenna;
  s.sd_ned_m = (fix.sd_ned_m.cwiseAbs2() + sd.cwiseAbs2()).cwiseSqrt();

  // Dilution falls with the root of the number of satellites; 8 of them in view give about 1.2.
  s.hdop = 3.5 / std::sqrt(std::max(fix.satellites, 1));
  s.vdop = 1.6 * s.hdop;
  s.tdop = 0.8 * s.hdop;
  s.pdop = std::hypot(s.hdop, s.vdop);
  return s;
}

std::string GpsReceiver::Sentence(AshtechMessage message, const GpsSolution& s) const {
  switch (message) {
    case AshtechMessage::kGga:
      return GgaSentence(s, options_.gga_quality);
    case AshtechMessage::kRmc:
      return RmcSentence(s);
    case AshtechMessage::kVtg:
      return VtgSentence(s);
    case AshtechMessage::kGst:
      return GstSentence(s);
    case AshtechMessage::kGsa:
      return GsaSentence(s);
    case AshtechMessage::kPos:
      return PosSentence(s);
    case AshtechMessage::kCbn:
      return CbnSentence(s);
    case AshtechMessage::kLtn:
      return LtnSentence(s);
    case AshtechMessage::kZda:
      return ZdaSentence(s);
    default:
      return {};
  }
}

void GpsReceiver::Send(core::MonoTime now, std::string text) {
  if (text.empty()) return;
  if (faults_.bad_checksum && text.size() > 4) {
    char& digit = text[text.size() - 3];
    digit = digit == '0' ? '1' : '0';
  }
  ++counters_.sentences;
  transmitter_.Send(now, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void GpsReceiver::SendEpoch(core::MonoTime now) {
  const RecordedFix& fix = recording_.fixes[next_fix_];
  ++counters_.epochs;
  const GpsSolution solution = Solve(fix, now);
  last_ = solution;
  const std::int64_t nmea_slot = SlotOf(fix.time, settings_.nmea_period);
  const std::int64_t raw_slot = SlotOf(fix.time, settings_.raw_period);
  const bool nmea = nmea_slot != std::exchange(last_nmea_slot_, nmea_slot);
  const bool raw = raw_slot != std::exchange(last_raw_slot_, raw_slot);
  for (std::size_t i = 0; i <= static_cast<std::size_t>(AshtechMessage::kZda); ++i) {
    const auto message = static_cast<AshtechMessage>(i);
    if (IsOn(message) && (message == AshtechMessage::kCbn ? raw : nmea))
      Send(now, Sentence(message, solution));
  }
}

void GpsReceiver::Advance(core::MonoTime now) {
  TakePulses();
  RaiseEdges(now);
  while (epoch_due_.IsSet() && epoch_due_ <= now) {
    // Scheduled, not actual time: a late wake-up of the simulator must not add to the modelled
    // latency.
    if (!faults_.power_off) SendEpoch(epoch_due_);
    ++next_fix_;
    ScheduleEpoch();
  }
  while (pps_ && pps_->send_at <= now) {
    if (!faults_.power_off && !faults_.no_pps && IsOn(AshtechMessage::kPtt))
      Send(pps_->send_at, PttSentence(TimeTag(pps_->time)));
    ScheduleReportOfPulse(pps_->time);
  }
  while (!events_.empty() && events_.front().send_at <= now) {
    const bool positioned = last_ && last_->rtk != core::RtkState::kNone;
    if (!faults_.power_off && positioned && IsOn(AshtechMessage::kTtt))
      Send(now, TttSentence(TimeTag(events_.front().time)));
    events_.pop_front();
  }
}

core::MonoTime GpsReceiver::NextEvent() const {
  core::MonoTime next = epoch_due_;
  const auto consider = [&next](core::MonoTime t) {
    if (!next.IsSet() || t < next) next = t;
  };
  if (pps_) consider(pps_->send_at);
  if (!events_.empty()) consider(events_.front().send_at);
  return next;
}

}  // namespace kawara::sim
