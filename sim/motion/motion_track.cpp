#include "sim/motion/motion_track.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kawara::sim {
namespace {

constexpr double kCourseMinSpeed_mps = 1.0;
/// How long the gyro is believed against the course: long enough to average the course's noise and
/// the gap between the two streams' stamps, short against the gyro's drift.
constexpr double kCourseTau_s = 4.0;

/// One direction of the drift filter: offset = course - integrated gyro, low-passed, weight of what
/// it rests on.
struct Drift {
  double offset_rad = 0.0;
  double weight = 0.0;
};

struct CoursePoint {
  core::GpsTime time;
  double offset_rad;  ///< course minus integrated gyro, any multiple of 2 pi
};

std::vector<Drift> FilterDrift(const std::vector<CoursePoint>& points, bool backward) {
  std::vector<Drift> result(points.size());
  Drift state;
  core::GpsTime last{};
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::size_t i = backward ? points.size() - 1 - k : k;
    const double dt_s = std::abs(core::ToSeconds(points[i].time - last));
    state.weight *= k == 0 ? 0.0 : std::exp(-dt_s / kCourseTau_s);
    last = points[i].time;
    double error_rad = core::WrapPi(points[i].offset_rad - state.offset_rad);
    if (state.weight > 0.0 && std::abs(error_rad) > core::kPi / 2.0) {
      error_rad =
          core::WrapPi(error_rad + core::kPi);  // driving backwards: the nose points the other way
    }
    state.weight += 1.0;
    state.offset_rad += error_rad / state.weight;
    result[i] = state;
  }
  return result;
}

/// Index of the last element not later than t, in [0, size - 2].
template <class Knots>
std::size_t SegmentOf(const Knots& knots, core::GpsTime t) {
  const auto after =
      std::upper_bound(knots.begin(), knots.end(), t,
                       [](core::GpsTime value, const auto& knot) { return value < knot.time; });
  const auto index =
      static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - knots.begin() - 1, 0));
  return std::min(index, knots.size() - 2);
}

double FractionOf(core::GpsTime t, core::GpsTime from, core::GpsTime to) {
  return std::clamp(core::ToSeconds(t - from) / core::ToSeconds(to - from), 0.0, 1.0);
}

double CatmullRom(double before, double from, double to, double after, double x) {
  const double m0 = 0.5 * (to - before);
  const double m1 = 0.5 * (after - from);
  const double x2 = x * x;
  const double x3 = x2 * x;
  return (2 * x3 - 3 * x2 + 1) * from + (x3 - 2 * x2 + x) * m0 + (3 * x2 - 2 * x3) * to +
         (x3 - x2) * m1;
}

}  // namespace

MotionTrack::MotionTrack(const Recording& recording) : fixes_(recording.fixes) {
  // The vehicle's turn rate is the gyro's z: a car's roll and pitch change it by less than a
  // percent.
  const core::Duration late = core::DurationFromSeconds(recording.site.imu_late_s);
  yaw_.reserve(recording.imu.size());
  double angle_rad = 0.0;
  for (std::size_t i = 0; i < recording.imu.size(); ++i) {
    const RecordedImu& sample = recording.imu[i];
    if (i > 0) {
      const RecordedImu& last = recording.imu[i - 1];
      angle_rad += 0.5 * (sample.rate_radps.z() + last.rate_radps.z()) *
                   core::ToSeconds(sample.time - last.time);
    }
    yaw_.push_back({sample.time - late, angle_rad});
  }

  std::vector<CoursePoint> points;
  for (const RecordedFix& fix : fixes_) {
    const double north = fix.velocity_ned_mps.x();
    const double east = fix.velocity_ned_mps.y();
    if (std::hypot(north, east) < kCourseMinSpeed_mps) continue;
    const std::size_t i = SegmentOf(yaw_, fix.time);
    const double x = FractionOf(fix.time, yaw_[i].time, yaw_[i + 1].time);
    const double gyro_rad = yaw_[i].yaw_rad + x * (yaw_[i + 1].yaw_rad - yaw_[i].yaw_rad);
    points.push_back({fix.time, std::atan2(east, north) - gyro_rad});
  }
  if (points.empty()) return;  // never moved: heading stays the gyro's own, from 0

  const std::vector<Drift> forward = FilterDrift(points, false);
  const std::vector<Drift> backward = FilterDrift(points, true);
  // Join the two at each point, then carry the joined drift along the gyro's samples.
  std::vector<double> drift(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double apart = core::WrapPi(backward[i].offset_rad - forward[i].offset_rad);
    const double share = backward[i].weight / (forward[i].weight + backward[i].weight);
    const double joined = forward[i].offset_rad + share * apart;
    drift[i] = i == 0 ? joined : drift[i - 1] + core::WrapPi(joined - drift[i - 1]);
  }
  std::size_t next = 0;
  for (YawKnot& knot : yaw_) {
    while (next < points.size() && points[next].time <= knot.time) ++next;
    if (next == 0) {
      knot.yaw_rad += drift.front();
    } else if (next == points.size()) {
      knot.yaw_rad += drift.back();
    } else {
      const double x = FractionOf(knot.time, points[next - 1].time, points[next].time);
      knot.yaw_rad += drift[next - 1] + x * (drift[next] - drift[next - 1]);
    }
  }
}

core::Geodetic MotionTrack::PositionAt(core::GpsTime t) const {
  const std::size_t i = SegmentOf(fixes_, t);
  const double x = FractionOf(t, fixes_[i].time, fixes_[i + 1].time);
  const core::Geodetic& before = fixes_[i == 0 ? 0 : i - 1].antenna;
  const core::Geodetic& from = fixes_[i].antenna;
  const core::Geodetic& to = fixes_[i + 1].antenna;
  const core::Geodetic& after = fixes_[std::min(i + 2, fixes_.size() - 1)].antenna;
  return {CatmullRom(before.lat_rad, from.lat_rad, to.lat_rad, after.lat_rad, x),
          CatmullRom(before.lon_rad, from.lon_rad, to.lon_rad, after.lon_rad, x),
          CatmullRom(before.h_ellipsoidal_m, from.h_ellipsoidal_m, to.h_ellipsoidal_m,
                     after.h_ellipsoidal_m, x)};
}

double MotionTrack::YawAt(core::GpsTime t) const {
  const std::size_t i = SegmentOf(yaw_, t);
  const double x = FractionOf(t, yaw_[i].time, yaw_[i + 1].time);
  return core::WrapPi(yaw_[i].yaw_rad + x * (yaw_[i + 1].yaw_rad - yaw_[i].yaw_rad));
}

const RecordedFix& MotionTrack::NearestFix(core::GpsTime t) const {
  const std::size_t i = SegmentOf(fixes_, t);
  return t - fixes_[i].time < fixes_[i + 1].time - t ? fixes_[i] : fixes_[i + 1];
}

}  // namespace kawara::sim
