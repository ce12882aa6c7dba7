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
    : config_(config), bucket_s_(core::ToSeconds(config.window) / 60.0) {}

void EnvelopeClock::Reset() {
  count_ = 0;
  samples_ = 0;
  candidate_ = {};
  expected_slope_ = slope_;
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
  expected_slope_ = slope_;
  const double last_x = c.last_x - c.lowest.x;
  Restart(c.lowest_stamp, c.lowest_arrival, arrival);
  last_x_ = last_x;
  return Result::kStepped;
}

void EnvelopeClock::Restart(StreamTime stamp, core::MonoTime arrival, core::MonoTime now) {
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
  const double expected_sigma = config_.skew_sigma_ppm * 1e-6;
  const double start_sigma = config_.delay_sigma_s / static_cast<double>(samples_);
  slope_ = expected_slope_;
  slope_sigma_ = expected_sigma;
  edge_sigma_s_ = start_sigma;
  const double span = points_[count_ - 1].x - points_[0].x;
  const auto touch = [this](double slope) {
    const auto lowest = std::min_element(
        points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count_),
        [&](const Point& a, const Point& b) { return a.y - slope * a.x < b.y - slope * b.x; });
    offset_ = lowest->y - slope * lowest->x;
    touch_x_ = lowest->x;
  };
  if (count_ >= 3) {
    const double edge_slope = EdgeSlope();
    touch(edge_slope);
    // The least delay of each bucket scatters above the edge; the edge, resting on the least of all
    // of them, is better known than each by at least the root of their number.
    double sum = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      sum += Square(points_[i].y - (offset_ + edge_slope * points_[i].x));
    }
    const auto n = static_cast<double>(count_);
    edge_sigma_s_ = std::max(start_sigma, 2.0 * std::sqrt(sum / n) / std::sqrt(n));
    const double edge_slope_sigma = 2.0 * edge_sigma_s_ / span;
    const double weight =
        Square(expected_sigma) / (Square(expected_sigma) + Square(edge_slope_sigma));
    const double limit = 10.0 * expected_sigma;
    slope_ = expected_slope_ + std::clamp(weight * (edge_slope - expected_slope_), -limit, limit);
    slope_sigma_ = std::sqrt(weight) * edge_slope_sigma;
  }
  touch(slope_);
}

double EnvelopeClock::EdgeSlope() const {
  // Lower hull, left to right (Andrew's monotone chain); points come sorted.
  std::array<Point, kPoints> hull;
  std::size_t n = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Point& p = points_[i];
    while (n >= 2) {
      const Point& a = hull[n - 2];
      const Point& b = hull[n - 1];
      if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0.0) break;
      --n;
    }
    hull[n++] = p;
  }
  const double middle = (points_[0].x + points_[count_ - 1].x) / 2.0;
  std::size_t right = 1;
  while (right + 1 < n && hull[right].x < middle) ++right;
  const Point& a = hull[right - 1];
  const Point& b = hull[right];
  return (b.y - a.y) / (b.x - a.x);
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
