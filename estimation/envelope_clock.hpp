#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "estimation/clock_types.hpp"

namespace kawara::estimation {

struct EnvelopeConfig {
  core::Duration window = core::Seconds(120);  ///< how far back the envelope looks
  /// Smallest time from the stamped instant to the arrival of its first byte, and how well that is
  /// known.
  double min_latency_s = 0.0;
  double min_latency_sigma_s = 0.005;
  double skew_sigma_ppm =
      50.0;  ///< how far apart the two crystals may be (1 sigma), before anything is measured
  double skew_wander_ppm_s =
      0.02;  ///< how fast that changes with temperature (1 sigma); matters in hold-over
  double delay_sigma_s = 0.05;  ///< typical delay of one sample, until the spread is measured
  /// Earlier than the envelope allows by more than this: the stream's clock has stepped.
  core::Duration step_threshold = core::Milliseconds(100);
  /// Later than this for confirm_late on end: not a delay any more, the stream's clock was set
  /// back.
  core::Duration max_delay = core::Seconds(10);
  core::Duration confirm_late = core::Seconds(10);
  int confirm_samples = 3;  ///< samples in a row that must agree before a step is believed
  core::Duration holdover_after = core::Seconds(3);
};

/// Maps a stream's own clock onto this machine's monotonic clock from (stamp, arrival) pairs alone.
/// Delays are only ever positive, so the truth is the LOWER edge of the cloud of arrival - stamp: a
/// line under all points of the sliding window. Bursts, late bursts and load lift points away from
/// that edge and change nothing.
///
/// Method: one point (the earliest relative to the line) is kept per 1/60 of the window; the lower
/// convex hull of these is rebuilt when it can have changed. Its edge over the middle of the window
/// is the line under all points with the least total distance (Moon, Skelly, Towsley, INFOCOM 1999;
/// Zhang, Liu, Xia, INFOCOM 2002); the lowest points of the first and last third along that edge
/// give the skew, drawn towards the skew of earlier windows while the present one says little; the
/// line of that skew touching the hull gives the offset. Never steps the monotonic side; never
/// reads a clock.
///
/// Sigma: known latency (+) scatter of the edge (+) skew over the distance (+) wander in hold-over.
/// Steps: samples earlier than possible, stamps running backwards, or far too late for long, are
/// refused until `confirm_samples` in a row agree with each other; then the envelope starts anew
/// there and steps is counted. A stream that is merely later than before (more latency) is NOT a
/// step and shifts nothing within the window.
///
/// Real-time safe: fixed memory, no allocation, at most one pass over 64 points a sample.
/// Deterministic. One thread.
class EnvelopeClock {
 public:
  enum class Result {
    kUsed,
    kIgnored,  ///< repeated or out-of-order stamp: carries no news
    kOutlier,  ///< refused for now
    kStepped,  ///< the stream's clock stepped; re-anchored here
  };

  explicit EnvelopeClock(const EnvelopeConfig& config = {});

  Result Add(StreamTime stamp, core::MonoTime arrival);
  /// Forgets everything but the counters and the skew (stream restarted by our own doing).
  void Reset();

  bool valid() const { return count_ > 0; }
  /// Meaningful only while valid(). Any instant, also outside the window (sigma grows).
  Aligned<core::MonoTime> ToMono(StreamTime stamp) const;
  Aligned<StreamTime> ToStream(core::MonoTime mono) const;
  ClockStatus Status(core::MonoTime now) const;
  core::MonoTime last_arrival() const { return last_arrival_; }

 private:
  static constexpr std::size_t kPoints = 64;
  /// Points that outlive the window when nothing newer comes.
  static constexpr std::size_t kKeep = 30;

  /// x: stamp - anchor [s]; y: (arrival - stamp) - the anchor's [s]. Small numbers, so doubles keep
  /// nanoseconds.
  struct Point {
    double x = 0.0;
    double y = 0.0;
  };
  enum class Reason : std::uint8_t { kEarly, kBackwards, kLate };
  /// Samples in a row that do not fit the line but fit each other.
  struct Candidate {
    int count = 0;
    Reason reason = Reason::kEarly;
    double first_y = 0.0;
    double last_x = 0.0;
    core::MonoTime first_arrival;
    Point lowest;
    StreamTime lowest_stamp;
    core::MonoTime lowest_arrival;
  };

  double Line(double x) const { return offset_ + slope_ * x; }
  Result Doubt(const Point& p, double residual, bool backwards, StreamTime stamp,
               core::MonoTime arrival);
  void Accept(const Point& p, double residual, core::MonoTime arrival);
  void Restart(StreamTime stamp, core::MonoTime arrival, core::MonoTime now);
  void Refit();
  /// Index of the point farthest below a line of this slope.
  std::size_t Lowest(std::size_t begin, std::size_t end, double slope) const;
  /// Of the hull of the first `count` points, over the middle of their span, refined by the lowest
  /// points of the first and last third.
  double EdgeSlope(std::size_t count) const;
  void Touch(double slope);
  double ExpectedSlopeSigma() const;
  void Learn();
  double SigmaAt(double x) const;

  const EnvelopeConfig config_;
  const double bucket_s_;

  std::int64_t anchor_stamp_ns_ = 0;
  std::int64_t anchor_y_ns_ = 0;
  std::array<Point, kPoints> points_{};  ///< ascending x, [0, count_)
  std::size_t count_ = 0;
  double bucket_start_x_ = 0.0;
  double last_x_ = 0.0;
  core::MonoTime last_arrival_;
  std::int64_t samples_ = 0;  ///< since the last restart
  Candidate candidate_;

  double offset_ = 0.0;  ///< of the line under the points [s]
  double slope_ = 0.0;   ///< d(arrival - stamp)/d(stamp): minus the stream's skew
  double touch_x_ = 0.0;
  double edge_sigma_s_ = 0.0;
  double slope_sigma_ = 0.0;
  double expected_slope_ = 0.0;  ///< learned from earlier windows
  double expected_sigma_ = 0.0;
  double learned_x_ = 0.0;

  std::int64_t steps_ = 0;
  std::int64_t outliers_ = 0;
};

}  // namespace kawara::estimation
