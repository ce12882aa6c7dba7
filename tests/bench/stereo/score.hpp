#pragma once
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tests/bench/stereo/rendered_pair.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::vision::stereo_bench {

/// Of this thread.
inline double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// A picture with its true pose.
struct Taken {
  const StereoLab::Frame* frame;
  Eigen::Isometry3d pose;
};

/// How distance images are judged, over all pairs of a condition: pixels whose true range is 2 to 6
/// m, 25 deg or more from the baseline, seen by both cameras (of several others: by any of them);
/// std of the errors within 10 % of the range, NMAD of all, outliers beyond 10 %, density.
struct Score {
  std::function<bool(std::size_t pixel)> judged;  ///< if set, only pixels for which it is true

  double wanted = 0, known = 0, near = 0, sum = 0, square = 0, honest = 0, cpu_s = 0, runs = 0;
  double vehicle_wanted = 0, vehicle_known = 0, vehicle_out = 0;
  std::vector<float> errors;

  void Add(const Pair& pair, const RangeImage& ranges, double seconds) {
    const Taken b{&pair.b, pair.pose_b};
    Add(*pair.model, {&pair.a, pair.pose_a}, std::span(&b, 1), ranges, seconds);
  }

  /// The baseline is that to the first of the others.
  void Add(const CameraModel& model, const Taken& a, std::span<const Taken> others,
           const RangeImage& ranges, double seconds) {
    cpu_s += seconds;
    runs += 1;
    const Eigen::Vector3d baseline =
        (others.front().pose.translation() - a.pose.translation()).normalized();
    for (int v = 0; v < ranges.height_px; ++v) {
      for (int u = 0; u < ranges.width_px; ++u) {
        const std::size_t i = ranges.index(u, v);
        const double truth = static_cast<double>(a.frame->range_m[i]);
        if (!(truth >= 2.0 && truth <= 6.0)) continue;
        if (judged && !judged(i)) continue;
        const Eigen::Vector3d ray = *model.Unproject({u, v});
        if (std::abs((a.pose.linear() * ray).dot(baseline)) > std::cos(25 * core::kRadFromDeg))
          continue;
        const Eigen::Vector3d point = a.pose * (truth * ray);
        if (!std::any_of(others.begin(), others.end(),
                         [&](const Taken& other) { return Sees(model, other, point); }))
          continue;
        const bool vehicle = a.frame->vehicle[i] != 0;
        wanted += 1;
        vehicle_wanted += vehicle ? 1 : 0;
        if (std::isnan(ranges.range_m[i])) continue;
        known += 1;
        vehicle_known += vehicle ? 1 : 0;
        const double error = static_cast<double>(ranges.range_m[i]) - truth;
        errors.push_back(static_cast<float>(std::abs(error)));
        if (std::abs(error) < 2.0 * static_cast<double>(ranges.sd_m[i])) honest += 1;
        if (std::abs(error) > 0.1 * truth) {
          vehicle_out += vehicle ? 1 : 0;
          continue;
        }
        near += 1;
        sum += error;
        square += error * error;
      }
    }
  }

  void Print(const std::string& condition, const std::string& method) {
    std::nth_element(errors.begin(),
                     errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    const double mean = sum / near;
    std::printf(
        "{\"condition\": \"%s\", \"method\": \"%s\", \"std_mm\": %.2f, \"nmad_mm\": %.2f, "
        "\"bias_mm\": %.2f, \"rms_mm\": %.2f, \"outliers\": %.3f, \"density\": %.2f, "
        "\"vehicle_outliers\": %.3f, "
        "\"vehicle_density\": %.2f, \"within_2_sd\": %.2f, \"cpu_ms\": %.1f}\n",
        condition.c_str(), method.c_str(), 1e3 * std::sqrt(square / near - mean * mean),
        1482.6 * static_cast<double>(errors[errors.size() / 2]), 1e3 * mean,
        1e3 * std::sqrt(square / near), 100.0 * (known - near) / known, 100.0 * known / wanted,
        100.0 * vehicle_out / std::max(1.0, vehicle_known),
        100.0 * vehicle_known / std::max(1.0, vehicle_wanted), 100.0 * honest / known,
        1e3 * cpu_s / runs);
    std::fflush(stdout);
  }

 private:
  static bool Sees(const CameraModel& model, const Taken& other, const Eigen::Vector3d& point) {
    const Eigen::Vector3d there = other.pose.inverse() * point;
    const auto pixel = model.Project(there);
    if (!pixel) return false;
    const auto u = std::lround(pixel->x()), v = std::lround(pixel->y());
    if (u < 0 || v < 0 || u >= other.frame->width_px || v >= other.frame->height_px) return false;
    const auto i = static_cast<std::size_t>(v * other.frame->width_px + u);
    return static_cast<double>(other.frame->range_m[i]) > 0.97 * there.norm();
  }
};

}  // namespace kawara::vision::stereo_bench
