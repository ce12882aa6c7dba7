#include "drivers/gnss_epoch.hpp"

namespace kawara::drivers {
namespace {

/// Epochs in a row until a habit is believed, and until it is given up.
constexpr int kHabit = 3;
/// Epochs in a row until a time line that contradicts the old one is believed.
constexpr int kBelieve = 5;
/// PBN messages in a row without anything better until they are taken for epochs.
constexpr int kPbnAlone = 5;
/// How far a receiver's clock may run ahead of the arrival stamps between two epochs (bursts after
/// a hold-up).
constexpr core::Duration kAhead = core::Seconds(2);
constexpr core::Duration kHalfDay = core::kDay / 2;

/// Step between two times of day, over midnight and through a leap second.
core::Duration Step(core::Duration from, core::Duration to) {
  if (from >= core::kDay && to < kHalfDay) return to + core::kDay + core::Seconds(1) - from;
  core::Duration step = to - from;
  if (step > kHalfDay) step -= core::kDay;
  if (step <= -kHalfDay) step += core::kDay;
  return step;
}

}  // namespace

void GnssEpochAssembler::OnMessage(const GnssMessage& message, GnssFixSink& sink) {
  if (IsInvalid(message)) return;
  newest_arrival_ = message.arrival;
  if (const auto* nmea = message.As<NmeaBody>()) AddNmea(*nmea, message.arrival, sink);
  if (const auto* ashtech = message.As<AshtechBody>()) AddAshtech(*ashtech, message.arrival, sink);
  if (const auto* pbn = message.As<AshtechPbn>()) AddPbn(*pbn, message.arrival, sink);
  if (const auto* ubx = message.As<UbxMessage>()) {
    if (const auto* pvt = std::get_if<UbxNavPvt>(&ubx->body)) AddPvt(*pvt, message.arrival, sink);
  }
}

void GnssEpochAssembler::Tick(core::MonoTime now, GnssFixSink& sink) {
  const bool waiting = open_ && !emitted_ && newest_arrival_.IsSet();
  if (!waiting || now - newest_arrival_ < config_.timeout) return;
  const std::uint64_t before = stats_.fixes;
  Emit(sink);
  stats_.timed_out += stats_.fixes - before;
}

void GnssEpochAssembler::Finish(GnssFixSink& sink) {
  CloseEpoch(sink);
  next_ = {};
  next_seen_ = 0;
}

void GnssEpochAssembler::AddNmea(const NmeaBody& body, core::MonoTime arrival, GnssFixSink& sink) {
  if (const auto* gga = std::get_if<NmeaGga>(&body)) {
    if (gga->time_utc) AddTimed(kGga, *gga->time_utc, *gga, &EpochParts::gga, arrival, sink);
  } else if (const auto* rmc = std::get_if<NmeaRmc>(&body)) {
    if (rmc->time_utc) AddTimed(kRmc, *rmc->time_utc, *rmc, &EpochParts::rmc, arrival, sink);
  } else if (const auto* gst = std::get_if<NmeaGst>(&body)) {
    if (gst->time_utc) AddTimed(kGst, *gst->time_utc, *gst, &EpochParts::gst, arrival, sink);
  } else if (const auto* vtg = std::get_if<NmeaVtg>(&body)) {
    AddUntimed(kVtg, *vtg, &EpochParts::vtg, arrival, sink);
  } else if (const auto* heading = std::get_if<NmeaHeading>(&body)) {
    AddUntimed(kHeading, *heading, &EpochParts::heading, arrival, sink);
  } else if (const auto* zda = std::get_if<NmeaZda>(&body)) {
    if (zda->has_date && zda->time_utc)
      clock_.SetDate(zda->year, zda->month, zda->day, *zda->time_utc, arrival);
  }
}

void GnssEpochAssembler::AddAshtech(const AshtechBody& body, core::MonoTime arrival,
                                    GnssFixSink& sink) {
  if (const auto* pos = std::get_if<AshtechPos>(&body)) {
    if (pos->time_utc) AddTimed(kPos, *pos->time_utc, *pos, &EpochParts::pos, arrival, sink);
  } else if (const auto* cbn = std::get_if<AshtechCbn>(&body)) {
    if (cbn->time_utc) AddTimed(kCbn, *cbn->time_utc, *cbn, &EpochParts::cbn, arrival, sink);
  } else if (const auto* latency = std::get_if<AshtechLatency>(&body)) {
    AddUntimed(kLatency, *latency, &EpochParts::latency, arrival, sink);
  }
}

void GnssEpochAssembler::AddPbn(const AshtechPbn& pbn, core::MonoTime arrival, GnssFixSink& sink) {
  const auto time = clock_.OfTimeOfWeek(pbn.time_of_week, arrival);
  if (!time) return;
  const core::Duration of_day = GnssClock::TimeOfDay(*time);
  if (pbn_alone_ < kPbnAlone && !(open_ && of_day == key_)) {
    ++pbn_alone_;
    return;
  }
  AddTimed(kPbn, of_day, pbn, &EpochParts::pbn, arrival, sink);
}

void GnssEpochAssembler::AddPvt(const UbxNavPvt& pvt, core::MonoTime arrival, GnssFixSink& sink) {
  if (pvt.has_date && !clock_.has_date()) {
    const core::Duration of_day = core::Seconds(pvt.hour * 3600 + pvt.minute * 60 + pvt.second);
    clock_.SetDate(pvt.year, pvt.month, pvt.day, of_day, arrival);
  }
  const auto time = clock_.OfTimeOfWeek(pvt.time_of_week, arrival);
  if (time) AddTimed(kPvt, GnssClock::TimeOfDay(*time), pvt, &EpochParts::pvt, arrival, sink);
}

template <class T>
void GnssEpochAssembler::AddTimed(Kind kind, core::Duration time_of_day, const T& contents,
                                  std::optional<T> EpochParts::*slot, core::MonoTime arrival,
                                  GnssFixSink& sink) {
  const bool same_epoch = open_ && time_of_day == key_;
  if (!EnterEpoch(time_of_day, arrival, sink)) return;
  // Did the untimed sentences since the last timed one arrive closer to it or to this one? Between
  // two of one epoch they belong to that epoch, wherever they lie.
  for (std::size_t k = 0; k < kKinds; ++k) {
    core::MonoTime& at = untimed_arrivals_[k];
    if (!at.IsSet()) continue;
    const bool leads = !same_epoch && arrival - at < at - timed_arrival_;
    int& leading = habits_[k].leading;
    if (leads && leading < kHabit) ++leading;
    if (!leads && leading > -kHabit) --leading;
    at = {};
  }
  timed_arrival_ = arrival;
  if ((Bit(kind) & kPrimary) != 0) pbn_alone_ = 0;
  if (emitted_) {
    if ((seen_ & Bit(kind)) == 0) ++stats_.late_sentences;
    seen_ |= Bit(kind);
    return;
  }
  parts_.*slot = contents;
  Seen(kind, sink);
}

template <class T>
void GnssEpochAssembler::AddUntimed(Kind kind, const T& contents,
                                    std::optional<T> EpochParts::*slot, core::MonoTime arrival,
                                    GnssFixSink& sink) {
  if (timed_arrival_.IsSet() && arrival.IsSet()) untimed_arrivals_[kind] = arrival;
  if (!open_ || habits_[kind].leading > 0) {
    if (next_seen_ == 0) next_arrival_ = arrival;
    next_.*slot = contents;
    next_seen_ |= Bit(kind);
    return;
  }
  if (emitted_) {
    if ((seen_ & Bit(kind)) == 0) ++stats_.late_sentences;
    seen_ |= Bit(kind);
    return;
  }
  parts_.*slot = contents;
  Seen(kind, sink);
}

/// Makes `time_of_day` the open epoch. False: a time that cannot be.
bool GnssEpochAssembler::EnterEpoch(core::Duration time_of_day, core::MonoTime arrival,
                                    GnssFixSink& sink) {
  if (open_ && time_of_day == key_) {
    rejected_run_ = 0;
    return true;
  }
  if (open_ && !IsNextEpoch(time_of_day, arrival)) return false;
  CloseEpoch(sink);
  open_ = true;
  emitted_ = false;
  key_ = time_of_day;
  parts_ = next_;
  seen_ = next_seen_;
  first_arrival_ = next_seen_ != 0 ? next_arrival_ : arrival;
  next_ = {};
  next_seen_ = 0;
  return true;
}

bool GnssEpochAssembler::IsNextEpoch(core::Duration time_of_day, core::MonoTime arrival) {
  const core::Duration step = Step(key_, time_of_day);
  const bool timed = arrival.IsSet() && timed_arrival_.IsSet() && arrival > timed_arrival_;
  const bool ahead = timed && step > arrival - timed_arrival_ + kAhead;
  if (step > core::Duration{} && !ahead) {
    rejected_run_ = 0;
    return true;
  }
  ++stats_.rejected_times;
  // Epochs, not sentences: several sentences of one rejected epoch count once.
  if (rejected_run_ > 0 && time_of_day == rejected_key_) return false;
  const bool in_order = rejected_run_ > 0 && Step(rejected_key_, time_of_day) > core::Duration{};
  rejected_run_ = in_order ? rejected_run_ + 1 : 1;
  rejected_key_ = time_of_day;
  if (rejected_run_ < kBelieve) return false;
  rejected_run_ = 0;
  ++stats_.time_steps;
  last_time_ = {};
  return true;
}

void GnssEpochAssembler::Seen(Kind kind, GnssFixSink& sink) {
  seen_ |= Bit(kind);
  unsigned expected = 0;
  for (std::size_t k = 0; k < kKinds; ++k) expected |= habits_[k].expected ? 1U << k : 0U;
  if (expected == 0 || (seen_ & expected) != expected) return;
  const std::uint64_t before = stats_.fixes;
  Emit(sink);
  stats_.completed += stats_.fixes - before;
}

void GnssEpochAssembler::CloseEpoch(GnssFixSink& sink) {
  if (!open_) return;
  if (!emitted_) Emit(sink);
  Learn();
  open_ = false;
}

void GnssEpochAssembler::Learn() {
  for (std::size_t k = 0; k < kKinds; ++k) {
    Habit& habit = habits_[k];
    const bool present = (seen_ & (1U << k)) != 0;
    habit.present = present ? std::min(habit.present + 1, kHabit) : 0;
    habit.absent = present ? 0 : std::min(habit.absent + 1, kHabit);
    if (habit.present == kHabit) habit.expected = true;
    if (habit.absent == kHabit) habit.expected = false;
  }
}

void GnssEpochAssembler::Emit(GnssFixSink& sink) {
  emitted_ = true;
  // Without a fix some receivers send a date out of nowhere.
  if (parts_.rmc && parts_.rmc->has_date && (parts_.rmc->valid || !clock_.has_date())) {
    const NmeaRmc& rmc = *parts_.rmc;
    clock_.SetDate(rmc.year, rmc.month, rmc.day, key_, first_arrival_);
  }
  stats_.rollovers = clock_.rollovers();
  const auto time = clock_.OfTimeOfDay(key_, first_arrival_);
  if (!time) {
    ++stats_.undated;
    return;
  }
  if (last_time_.IsSet() && *time <= last_time_) {
    ++stats_.rejected_times;
    // The date was wrong before, it seems, and time goes on well now.
    if (++backwards_run_ < kBelieve) return;
    ++stats_.time_steps;
  }
  backwards_run_ = 0;
  last_time_ = *time;
  core::GnssFix fix = MakeFix(parts_, config_.profile);
  fix.time = *time;
  fix.arrival = first_arrival_;
  ++stats_.fixes;
  sink.OnFix(fix);
}

}  // namespace kawara::drivers
