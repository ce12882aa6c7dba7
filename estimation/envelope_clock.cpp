#include "estimation/envelope_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kawara::estimation {
namespace {

constexpr double kNs = 1e-9;
/// Beyond this (about 146 years) differences could overflow; no clock of ours shows it.
constexpr std::int64_t kMaxNs = std::numeric_limits<std::int64_t>::max() / 4;
/// Before this much of the stream has been seen a correction is start-up, not a step worth
/// counting.
constexpr double kSettleS = 10.0;

bool InRange(std::int64_t ns) { return ns > -kMaxNs && ns < kMaxNs; }

double Square(double v) { return v * v; }

std::int64_t ToNs(double seconds) { return core::DurationFromSeconds(seconds).count(); }

}  // namespace

const char* ToString(ClockSource s) {
  switch (s) {
    case ClockSource::kNone:
      return "none";
    case ClockSource::kEnvelope:
      return "envelope";
    case ClockSource::kPps:
      return "pps";
    case ClockSource::kHoldover:
      return "hold-over";
  }
  return "none";
}

EnvelopeClock::EnvelopeClock(const EnvelopeConfig& config)
    : config_(config),
      bucket_s_(core::ToSeconds(config.window) / 60.0),
      expected_sigma_(config.skew_sigma_ppm * 1e-6) {}

void EnvelopeClock::Reset() {
  count_ = 0;
  samples_ = 0;
  candidate_ = {};
}

EnvelopeClock::Result EnvelopeClock::Add(StreamTime stamp, core::MonoTime arrival) {
  if (!InRange(stamp.ns()) || !InRange(arrival.ns())) {
    ++outliers_;
    return Result::kOutlier;
  }
  if (count_ == 0) {
    Restart(stamp, arrival, arrival);
    return Result::kUsed;
  }
  const Point p{static_cast<double>(stamp.ns() - anchor_stamp_ns_) * kNs,
                static_cast<double>(arrival.ns() - stamp.ns() - anchor_y_ns_) * kNs};
  const double residual = p.y - Line(p.x);
  const double threshold = core::ToSeconds(config_.step_threshold);
  const bool backwards = p.x <= last_x_;
  if (backwards && std::abs(residual) <= threshold) return Result::kIgnored;
  const bool doubtful =
      backwards || residual < -threshold || residual > core::ToSeconds(config_.max_delay) ||
      // While a step is suspected, what fits it better than the old line speaks for it.
      (candidate_.count > 0 && std::abs(p.y - candidate_.first_y) < std::abs(residual));
  if (doubtful) return Doubt(p, residual, backwards, stamp, arrival);
  outliers_ += candidate_.count;
  candidate_.count = 0;
  Accept(p, residual, arrival);
  return Result::kUsed;
}

EnvelopeClock::Result EnvelopeClock::Doubt(const Point& p, double residual, bool backwards,
                                           StreamTime stamp, core::MonoTime arrival) {
  Candidate& c = candidate_;
  if (c.count > 0 && std::abs(p.y - c.first_y) <= core::ToSeconds(config_.step_threshold) &&
      p.x > c.last_x) {
    ++c.count;
  } else {
    outliers_ += c.count;
    c = {};
    c.count = 1;
    c.reason = residual < 0.0 ? Reason::kEarly : (backwards ? Reason::kBackwards : Reason::kLate);
    c.first_y = p.y;
    c.first_arrival = arrival;
  }
  if (c.count == 1 || p.y < c.lowest.y) {
    c.lowest = p;
    c.lowest_stamp = stamp;
    c.lowest_arrival = arrival;
  }
  c.last_x = p.x;
  const bool confirmed =
      c.count >= config_.confirm_samples &&
      (c.reason != Reason::kLate || arrival - c.first_arrival >= config_.confirm_late);
  if (!confirmed) return Result::kOutlier;
  const bool start_up = c.reason == Reason::kEarly && last_x_ - points_[0].x < kSettleS;
  if (!start_up) ++steps_;
  const double last_x = c.last_x - c.lowest.x;
  Restart(c.lowest_stamp, c.lowest_arrival, arrival);
  last_x_ = last_x;
  return Result::kStepped;
}

void EnvelopeClock::Restart(StreamTime stamp, core::MonoTime arrival, core::MonoTime now) {
  // The crystals are the same as before: what was learned of the skew stays.
  expected_sigma_ = ExpectedSlopeSigma();
  learned_x_ = 0.0;
  anchor_stamp_ns_ = stamp.ns();
  anchor_y_ns_ = arrival.ns() - stamp.ns();
  count_ = 1;
  samples_ = 1;
  points_[0] = {0.0, 0.0};
  bucket_start_x_ = 0.0;
  last_x_ = 0.0;
  last_arrival_ = now;
  candidate_ = {};
  Refit();
}

void EnvelopeClock::Accept(const Point& p, double residual, core::MonoTime arrival) {
  last_x_ = p.x;
  last_arrival_ = arrival;
  ++samples_;
  if (p.x - bucket_start_x_ >= bucket_s_) {
    if (count_ == kPoints) {
      std::copy(points_.begin() + 1, points_.end(), points_.begin());
      --count_;
    }
    bucket_start_x_ = p.x;
    points_[count_++] = p;
    Refit();
  } else if (Point& newest = points_[count_ - 1]; residual < newest.y - Line(newest.x)) {
    newest = p;
    Refit();
  }
}

void EnvelopeClock::Refit() {
  std::size_t expired = 0;
  const double oldest_x = points_[count_ - 1].x - core::ToSeconds(config_.window);
  while (count_ - expired > kKeep && points_[expired].x < oldest_x) ++expired;
  if (expired > 0) {
    std::copy(points_.begin() + static_cast<std::ptrdiff_t>(expired),
              points_.begin() + static_cast<std::ptrdiff_t>(count_), points_.begin());
    count_ -= expired;
  }
  const double expected_sigma = ExpectedSlopeSigma();
  edge_sigma_s_ = config_.delay_sigma_s / static_cast<double>(samples_);
  slope_ = expected_slope_;
  slope_sigma_ = expected_sigma;
  // The newest bucket is still open: what it holds so far may be no minimum at all. It can lower
  // the line, but says nothing about its slope and scatter.
  const std::size_t closed = count_ - 1;
  if (closed >= 3) {
    const double edge_slope = EdgeSlope(closed);
    Touch(edge_slope);
    // The least delays of the buckets scatter above the edge; the edge, resting on the least of all
    // of them, is better known than each by the root of their number. Median: half the buckets may
    // be bad.
    std::array<double, kPoints> above;
    for (std::size_t i = 0; i < closed; ++i) {
      above[i] = points_[i].y - (offset_ + edge_slope * points_[i].x);
    }
    const auto middle = above.begin() + static_cast<std::ptrdiff_t>(closed / 2);
    std::nth_element(above.begin(), middle, above.begin() + static_cast<std::ptrdiff_t>(closed));
    edge_sigma_s_ = std::max(edge_sigma_s_, 3.0 * *middle / std::sqrt(static_cast<double>(closed)));
    const double span = points_[closed - 1].x - points_[0].x;
    const double edge_slope_sigma = 2.0 * edge_sigma_s_ / span;
    const double weight =
        Square(expected_sigma) / (Square(expected_sigma) + Square(edge_slope_sigma));
    const double limit = 4.0 * expected_sigma;
    slope_ += std::clamp(weight * (edge_slope - expected_slope_), -limit, limit);
    slope_sigma_ = std::sqrt(weight) * edge_slope_sigma;
  }
  Touch(slope_);
  Learn();
}

std::size_t EnvelopeClock::Lowest(std::size_t begin, std::size_t end, double slope) const {
  std::size_t lowest = begin;
  for (std::size_t i = begin + 1; i < end; ++i) {
    const double dx = points_[i].x - points_[lowest].x;
    if (points_[i].y - points_[lowest].y < slope * dx) lowest = i;
  }
  return lowest;
}

void EnvelopeClock::Touch(double slope) {
  const Point& lowest = points_[Lowest(0, count_, slope)];
  offset_ = lowest.y - slope * lowest.x;
  touch_x_ = lowest.x;
}

double EnvelopeClock::ExpectedSlopeSigma() const {
  return std::min(
      std::hypot(expected_sigma_, config_.skew_wander_ppm_s * 1e-6 * (last_x_ - learned_x_)),
      config_.skew_sigma_ppm * 1e-6);
}

void EnvelopeClock::Learn() {
  // Once a window, so that no sample speaks twice; tripled, because delays are not always kind.
  if (last_x_ - learned_x_ < core::ToSeconds(config_.window)) return;
  expected_sigma_ = std::min(3.0 * slope_sigma_, ExpectedSlopeSigma());
  expected_slope_ = slope_;
  learned_x_ = last_x_;
}

double EnvelopeClock::EdgeSlope(std::size_t count) const {
  // Lower hull, left to right (Andrew's monotone chain); points come sorted.
  std::array<Point, kPoints> hull;
  std::size_t n = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Point& p = points_[i];
    while (n >= 2) {
      const Point& a = hull[n - 2];
      const Point& b = hull[n - 1];
      if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0.0) break;
      --n;
    }
    hull[n++] = p;
  }
  const double middle = (points_[0].x + points_[count - 1].x) / 2.0;
  std::size_t right = 1;
  while (right + 1 < n && hull[right].x < middle) ++right;
  const Point& a = hull[right - 1];
  const Point& b = hull[right];
  double slope = (b.y - a.y) / (b.x - a.x);
  // That edge may be short. Seen along it, the lowest points of the first and of the last third
  // give a long lever.
  const std::size_t third = count / 3;
  for (int round = 0; round < 2; ++round) {
    const Point& first = points_[Lowest(0, third, slope)];
    const Point& last = points_[Lowest(count - third, count, slope)];
    slope = (last.y - first.y) / (last.x - first.x);
  }
  return slope;
}

double EnvelopeClock::SigmaAt(double x) const {
  const double ahead_s = std::max(0.0, x - last_x_);
  const double wander = 0.5 * config_.skew_wander_ppm_s * 1e-6 * Square(ahead_s);
  return std::sqrt(Square(config_.min_latency_sigma_s) + Square(edge_sigma_s_) +
                   Square(slope_sigma_ * (x - touch_x_)) + Square(wander));
}

Aligned<core::MonoTime> EnvelopeClock::ToMono(StreamTime stamp) const {
  const std::int64_t stamp_ns = std::clamp(stamp.ns(), -kMaxNs, kMaxNs);
  const double x = static_cast<double>(stamp_ns - anchor_stamp_ns_) * kNs;
  return {core::MonoTime::FromNs(stamp_ns + anchor_y_ns_ + ToNs(Line(x) - config_.min_latency_s)),
          SigmaAt(x)};
}

Aligned<StreamTime> EnvelopeClock::ToStream(core::MonoTime mono) const {
  // mono = x + Line(x) - latency, all relative to the anchor; solved for x, then written as mono
  // plus a small correction so that the nanoseconds of the integer part survive.
  const std::int64_t anchor_arrival_ns = anchor_stamp_ns_ + anchor_y_ns_;
  const std::int64_t relative_ns = std::clamp(mono.ns(), -kMaxNs, kMaxNs) - anchor_arrival_ns;
  const double x =
      (static_cast<double>(relative_ns) * kNs - offset_ + config_.min_latency_s) / (1.0 + slope_);
  const std::int64_t correction_ns = ToNs(config_.min_latency_s - Line(x));
  return {StreamTime::FromNs(anchor_stamp_ns_ + relative_ns + correction_ns), SigmaAt(x)};
}

ClockStatus EnvelopeClock::Status(core::MonoTime now) const {
  ClockStatus status;
  status.mono = now;
  status.steps = steps_;
  status.outliers = outliers_;
  if (!valid()) return status;
  const Aligned<StreamTime> stream = ToStream(now);
  status.stream = stream.time;
  status.sigma_s = stream.sigma_s;
  status.skew_ppm = -slope_ * 1e6;
  status.source = now - last_arrival_ > config_.holdover_after ? ClockSource::kHoldover
                                                               : ClockSource::kEnvelope;
  return status;
}

}  // namespace kawara::estimation
