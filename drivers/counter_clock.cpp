#include "drivers/counter_clock.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::drivers {
namespace {

constexpr std::int64_t kWrapTicks = 65'536;
constexpr double kFirstWindowS = 0.25;
constexpr double kLongestWindowS = 4.0;
/// Below this span the envelope's slope is noise (1 ms of jitter over 1 s is 0.1 %): only its
/// height is used.
constexpr double kShortestSlopeSpanS = 1.0;
/// Two steps within this fraction are "the same period".
constexpr double kPeriodTolerance = 0.15;
constexpr int kPeriodTrusted = 4;

}  // namespace

CounterClock::CounterClock(CounterClockConfig config) : config_(config), rate_ns_(config.tick_ns) {}

void CounterClock::Restart() {
  anchored_ = false;
  period_votes_ = 0;
}

core::MonoTime CounterClock::Update(std::uint16_t counter, core::MonoTime arrival,
                                    bool bytes_lost) {
  ++stats_.packets;
  if (!anchored_ || arrival - last_arrival_ > config_.max_gap ||
      arrival < last_arrival_ - config_.max_gap) {
    return Anchor(counter, arrival);
  }
  const auto step = static_cast<std::uint16_t>(last_counter_ - counter);
  const std::int64_t arrival_ns = (arrival.ns() - anchor_ns_);
  const auto residual =
      static_cast<std::int64_t>(static_cast<double>(arrival_ns) - Predict(ticks_ + step));
  const std::int64_t wraps = ChooseWraps(step, residual, bytes_lost);
  // Negative: an earlier packet was given a wrap too many, everything since is wrong.
  if (wraps < 0) return Anchor(counter, arrival);
  const std::int64_t step_ticks = step + wraps * kWrapTicks;
  ticks_ += step_ticks;
  last_counter_ = counter;
  last_arrival_ = arrival;
  const auto delay = static_cast<std::int64_t>(static_cast<double>(arrival_ns) - Predict(ticks_));
  if (PersistentlyLate(delay)) return Anchor(counter, arrival);
  LearnPeriod(step_ticks);
  AddToEnvelope(ticks_, arrival_ns);
  last_delay_ns_ = std::max<std::int64_t>(delay, 0);
  const core::MonoTime sampled = core::MonoTime::FromNs(anchor_ns_ + std::llround(Predict(ticks_)));
  return Finish(sampled);
}

core::MonoTime CounterClock::Anchor(std::uint16_t counter, core::MonoTime arrival) {
  ++stats_.restarts;
  anchored_ = true;
  last_counter_ = counter;
  last_arrival_ = arrival;
  ticks_ = 0;
  anchor_ns_ = arrival.ns();
  offset_ns_ = 0.0;
  last_delay_ns_ = 0;
  recent_count_ = 0;
  closed_count_ = 0;
  window_open_ = false;
  window_ticks_ = static_cast<std::int64_t>(kFirstWindowS * 1e9 / config_.tick_ns);
  AddToEnvelope(0, 0);
  return Finish(arrival);
}

double CounterClock::Predict(std::int64_t ticks) const {
  return offset_ns_ + rate_ns_ * static_cast<double>(ticks);
}

/// `residual_ns`: arrival minus the envelope if there was no wrap beyond the one `step` may hold.
std::int64_t CounterClock::ChooseWraps(std::uint16_t step, std::int64_t residual_ns,
                                       bool bytes_lost) const {
  const double wrap_ns = rate_ns_ * kWrapTicks;
  // A quarter wrap earlier than the envelope is still "on time": the envelope itself is an
  // estimate.
  const double slack_ns = 0.25 * wrap_ns;
  const auto most = static_cast<std::int64_t>(
      std::floor((static_cast<double>(residual_ns) + slack_ns) / wrap_ns));
  if (most <= 0) return most;
  if (!bytes_lost && period_votes_ >= kPeriodTrusted) {
    const auto usual = std::llround((period_ticks_ - step) / static_cast<double>(kWrapTicks));
    const double step_ticks = static_cast<double>(step + usual * kWrapTicks);
    if (usual >= 0 && usual < most &&
        std::abs(step_ticks - period_ticks_) < kPeriodTolerance * period_ticks_) {
      return usual;
    }
  }
  return most;
}

void CounterClock::LearnPeriod(std::int64_t step_ticks) {
  const auto step = static_cast<double>(step_ticks);
  if (period_votes_ > 0 && std::abs(step - period_ticks_) < kPeriodTolerance * period_ticks_) {
    period_votes_ = std::min(period_votes_ + 1, 2 * kPeriodTrusted);
    period_ticks_ += 0.1 * (step - period_ticks_);
  } else if (--period_votes_ <= 0) {
    period_votes_ = 1;
    period_ticks_ = step;
  }
}

/// Held-up packets catch up (their delays shrink); a wrong wrap count stays, by whole wraps.
bool CounterClock::PersistentlyLate(std::int64_t residual_ns) {
  const double wrap_ns = rate_ns_ * kWrapTicks;
  if (static_cast<double>(residual_ns) < 0.5 * wrap_ns) {
    recent_count_ = 0;
    return false;
  }
  ++stats_.late;
  recent_residuals_[recent_count_++] = residual_ns;
  if (recent_count_ < kRecent) return false;
  const auto [least, most] =
      std::minmax_element(recent_residuals_.begin(), recent_residuals_.end());
  const bool steady = static_cast<double>(*most - *least) < 0.25 * wrap_ns;
  std::move(recent_residuals_.begin() + 1, recent_residuals_.end(), recent_residuals_.begin());
  --recent_count_;
  return steady;
}

void CounterClock::AddToEnvelope(std::int64_t ticks, std::int64_t arrival_ns) {
  if (window_open_ && ticks - window_start_ticks_ >= window_ticks_) CloseWindow();
  const double residual = static_cast<double>(arrival_ns) - Predict(ticks);
  if (residual < 0.0) offset_ns_ += residual;
  if (!window_open_) {
    window_open_ = true;
    window_start_ticks_ = ticks;
    window_best_ = {ticks, arrival_ns};
    return;
  }
  const double best = static_cast<double>(window_best_.arrival_ns) - Predict(window_best_.ticks);
  if (residual < best) window_best_ = {ticks, arrival_ns};
}

void CounterClock::CloseWindow() {
  if (closed_count_ == kWindows) {
    const auto longest = static_cast<std::int64_t>(kLongestWindowS * 1e9 / config_.tick_ns);
    if (window_ticks_ < longest) {
      // Twice the window, half as many: history grows at constant cost.
      for (std::size_t i = 0; i < kWindows / 2; ++i) {
        const Point& a = closed_[2 * i];
        const Point& b = closed_[2 * i + 1];
        const bool a_lower = static_cast<double>(a.arrival_ns) - Predict(a.ticks) <=
                             static_cast<double>(b.arrival_ns) - Predict(b.ticks);
        closed_[i] = a_lower ? a : b;
      }
      closed_count_ = kWindows / 2;
      window_ticks_ *= 2;
    } else {
      std::move(closed_.begin() + 1, closed_.end(), closed_.begin());
      closed_count_ = kWindows - 1;
    }
  }
  closed_[closed_count_++] = window_best_;
  window_open_ = false;
  Refit();
}

/// The line below all points with the least total distance to them: it touches two neighbours of
/// the lower convex hull, the ones on either side of the points' mean.
void CounterClock::Refit() {
  const auto slope_between = [](const Point& a, const Point& b) {
    return static_cast<double>(b.arrival_ns - a.arrival_ns) /
           static_cast<double>(b.ticks - a.ticks);
  };
  std::array<Point, kWindows> hull{};
  std::size_t n = 0;
  double mean_ticks = 0.0;
  for (std::size_t i = 0; i < closed_count_; ++i) {
    const Point& p = closed_[i];
    mean_ticks += static_cast<double>(p.ticks) / static_cast<double>(closed_count_);
    while (n >= 2 && slope_between(hull[n - 2], hull[n - 1]) >= slope_between(hull[n - 1], p)) --n;
    hull[n++] = p;
  }
  if (n < 2) return;
  const double span_s =
      static_cast<double>(hull[n - 1].ticks - hull[0].ticks) * config_.tick_ns * 1e-9;
  if (span_s >= kShortestSlopeSpanS) {
    std::size_t edge = 0;
    while (edge + 2 < n && static_cast<double>(hull[edge + 1].ticks) < mean_ticks) ++edge;
    rate_ns_ = std::clamp(slope_between(hull[edge], hull[edge + 1]),
                          config_.tick_ns * (1.0 - config_.max_skew),
                          config_.tick_ns * (1.0 + config_.max_skew));
  }
  offset_ns_ =
      static_cast<double>(hull[0].arrival_ns) - rate_ns_ * static_cast<double>(hull[0].ticks);
  for (std::size_t i = 1; i < n; ++i) {
    offset_ns_ = std::min(offset_ns_, static_cast<double>(hull[i].arrival_ns) -
                                          rate_ns_ * static_cast<double>(hull[i].ticks));
  }
}

core::MonoTime CounterClock::Finish(core::MonoTime sampled) {
  sampled = sampled - config_.latency;
  if (last_stamp_.IsSet() && sampled <= last_stamp_) {
    ++stats_.held_back;
    sampled = last_stamp_ + core::Nanoseconds(1000);
  }
  last_stamp_ = sampled;
  return sampled;
}

}  // namespace kawara::drivers
