#pragma once
#include <kawara/ahrs_sample_t.hpp>
#include <kawara/clock_t.hpp>
#include <kawara/gnss_fix_t.hpp>
#include <kawara/navigation_t.hpp>
#include <kawara/pose_t.hpp>
#include <string_view>

#include "core/expected.hpp"
#include "core/measurements.hpp"
#include "estimation/clock_types.hpp"
#include "estimation/navigation_report.hpp"

/// Between the plain types of the rooms below and their LCM messages. Angles are radians here,
/// degrees in messages; every number goes over and back within one rounding (1e-15 of its size),
/// NaN stays NaN. ToMessage never fails. FromMessage takes messages from outside: kFormat for an
/// enumeration out of range, a position off the globe, or a NaN where a number must be.
namespace kawara::comms {

gnss_fix_t ToMessage(const core::GnssFix& fix);
[[nodiscard]] core::Expected<core::GnssFix> FromMessage(const gnss_fix_t& message);

/// `sampled_gps`: the sample's time on the GPS time line; not set while not aligned.
ahrs_sample_t ToMessage(const core::AhrsSample& sample, core::GpsTime sampled_gps);
[[nodiscard]] core::Expected<core::AhrsSample> FromMessage(const ahrs_sample_t& message);

pose_t ToMessage(const core::Pose& pose);
[[nodiscard]] core::Expected<core::Pose> FromMessage(const pose_t& message);

/// `stream`: "gps", "ahrs" or "pps".
clock_t ToMessage(const estimation::ClockStatus& status, std::string_view stream = "gps");
[[nodiscard]] core::Expected<estimation::ClockStatus> FromMessage(const clock_t& message);

/// Robot and mission are the caller's to fill in. One way: nobody needs it back.
navigation_t ToMessage(const estimation::NavigationReport& report);

}  // namespace kawara::comms
