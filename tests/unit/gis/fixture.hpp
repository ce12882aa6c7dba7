#pragma once
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "gis/dump.hpp"
#include "gis/records.hpp"
#include "gis/store.hpp"
#include "tests/support/test_folder.hpp"

namespace kawara::gis::testing {

using kawara::testing::TestFolder;

/// Bytes with the segments of a JPEG (SOI, SOF0, SOS, noise, EOI): all that the store looks at.
inline std::shared_ptr<const std::vector<std::uint8_t>> Jpeg(unsigned width, unsigned height,
                                                             std::size_t noise, unsigned seed = 1) {
  const auto high = [](unsigned v) { return static_cast<std::uint8_t>(v >> 8 & 0xff); };
  const auto low = [](unsigned v) { return static_cast<std::uint8_t>(v & 0xff); };
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(std::vector<std::uint8_t>{
      0xff,        0xd8,       0xff, 0xc0, 0,    11, 8,    high(height), low(height),
      high(width), low(width), 1,    1,    0x11, 0,  0xff, 0xda,         0,
      8,           1,          1,    0,    0,    63, 0});
  for (std::size_t i = 0; i < noise; ++i) {
    seed = seed * 1664525U + 1013904223U;
    bytes->push_back(static_cast<std::uint8_t>(seed >> 24 & 0x7f));  // never 0xff
  }
  bytes->insert(bytes->end(), {0xff, 0xd9});
  return bytes;
}

inline const core::GpsTime kStart =
    core::ToGps(core::FromCivil({2026, 11, 22, 6, 25, 23, 0}));  // on a whole second

inline PoseFields PoseAt(double seconds) {
  PoseFields p;
  p.time = kStart + core::DurationFromSeconds(seconds);
  p.lat_deg = 35.7061 + seconds * 1e-5;
  p.lon_deg = 139.7061 + seconds * 0.7e-5;
  p.h_ellipsoidal_m = 61.25;
  p.roll_deg = 0.5;
  p.pitch_deg = -1.25;
  p.yaw_deg = 33.0;
  p.velocity_enu_mps = {0.6, 1.1, 0.0};
  p.position_sd_enu_m = {0.011, 0.012, 0.02};
  p.attitude_sd_deg = {0.1, 0.1, 0.4};
  p.rtk = core::RtkState::kFixed;
  p.gnss_age_s = 0.05;
  return p;
}

inline PoseRecord Pose(double seconds, const std::string& robot = "rover-1",
                       const std::string& mission = "20261122T062523Z") {
  return {.robot = robot, .mission = mission, .pose = PoseAt(seconds)};
}

inline PanoramaRecord Panorama(std::int64_t epoch, PictureStage stage,
                               const std::string& robot = "rover-1",
                               const std::string& mission = "20261122T062523Z") {
  PanoramaRecord r;
  r.robot = robot;
  r.mission = mission;
  r.epoch = epoch;
  r.stage = stage;
  r.pose = PoseAt(static_cast<double>(epoch));
  r.projection = "equirectangular";
  r.width = stage == PictureStage::kFull ? 512 : 128;
  r.height = r.width / 2;
  r.jpeg = Jpeg(r.width, r.height, stage == PictureStage::kFull ? 4000 : 300,
                static_cast<unsigned>(epoch));
  return r;
}

inline EventRecord Event(double seconds, const std::string& text) {
  return {.robot = "rover-1",
          .mission = "20261122T062505Z",
          .mono = core::MonoTime::FromNs(static_cast<std::int64_t>(seconds * 1e9)),
          .time = kStart + core::DurationFromSeconds(seconds),
          .severity = 1,
          .name = "gps.unplugged",
          .text = text};
}

inline std::string Dump(const std::filesystem::path& store) {
  std::ostringstream out;
  const auto dumped = DumpStore(store.string(), {}, out);
  EXPECT_TRUE(dumped) << dumped.error().message;
  return out.str();
}

/// What a command prints; its exit status is expected to be 0.
inline std::string Shell(const std::string& command) {
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> chunk{};
  while (const std::size_t n = std::fread(chunk.data(), 1, chunk.size(), pipe))
    text.append(chunk.data(), n);
  EXPECT_EQ(::pclose(pipe), 0) << command << "\n" << text;
  return text;
}

}  // namespace kawara::gis::testing
