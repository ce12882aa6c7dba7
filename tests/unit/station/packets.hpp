#pragma once
#include <cstdint>
#include <kawara/event_t.hpp>
#include <kawara/phase1_t.hpp>
#include <kawara/pose_t.hpp>
#include <kawara/robot_pose_t.hpp>
#include <string>
#include <vector>

#include "core/time.hpp"

namespace kawara::station::testing {

inline const core::GpsTime kStart = core::ToGps(core::FromCivil({2026, 11, 22, 6, 25, 5, 0}));

inline pose_t PoseMessage(double seconds) {
  pose_t p{};
  p.gps_ns = (kStart + core::DurationFromSeconds(seconds)).ns();
  p.mono_ns = static_cast<std::int64_t>((1000 + seconds) * 1e9);
  p.valid = true;
  p.rtk_state = 4;
  p.lat_deg = 35.7061 + seconds * 1e-5;
  p.lon_deg = 139.7061;
  p.h_ellipsoidal_m = 61.0;
  p.yaw_deg = 30.0;
  p.position_cov_enu_m2[0] = 1e-4;
  p.position_cov_enu_m2[4] = 4e-4;
  p.position_cov_enu_m2[8] = -1.0;  // unknown
  return p;
}

inline robot_pose_t RobotPose(double seconds, const std::string& robot = "rover-1",
                              const std::string& mission = "20261122T062505Z") {
  robot_pose_t m;
  m.robot = robot;
  m.mission = mission;
  m.pose = PoseMessage(seconds);
  return m;
}

/// With the segments of a JPEG: SOI, SOF0, SOS, a little data, EOI.
inline phase1_t Packet(std::int64_t epoch, int stage, const std::string& robot = "rover-1",
                       const std::string& mission = "20261122T062505Z") {
  phase1_t m;
  m.robot = robot;
  m.mission = mission;
  m.epoch = epoch;
  m.stage = static_cast<std::int8_t>(stage);
  m.reason = 0;
  m.pose = PoseMessage(static_cast<double>(epoch));
  m.gps_minus_utc_s = 18;
  m.projection = "equirectangular";
  m.width = stage == 1 ? 512 : 128;
  m.height = m.width / 2;
  const auto high = [](std::int32_t v) { return static_cast<std::uint8_t>(v >> 8); };
  const auto low = [](std::int32_t v) { return static_cast<std::uint8_t>(v & 0xff); };
  m.jpeg = {0xff,
            0xd8,
            0xff,
            0xc0,
            0,
            11,
            8,
            high(m.height),
            low(m.height),
            high(m.width),
            low(m.width),
            1,
            1,
            0x11,
            0,
            0xff,
            0xda,
            0,
            8,
            1,
            1,
            0,
            0,
            63,
            0,
            1,
            2,
            3,
            0xff,
            0xd9};
  m.n = static_cast<std::int32_t>(m.jpeg.size());
  return m;
}

}  // namespace kawara::station::testing
