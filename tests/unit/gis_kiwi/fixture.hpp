#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/changed_object.hpp"
#include "gis/kiwi/object_register.hpp"
#include "tests/unit/gis/fixture.hpp"

namespace kawara::gis::testing {

inline const core::Geodetic kOrigin{35.7061 * core::kRadFromDeg, 139.7061 * core::kRadFromDeg,
                                    61.25};
inline const core::UtcTime kNoon = core::FromCivil({2026, 11, 22, 12, 0, 0, 123'456'789});

inline core::UtcTime At(double seconds) { return kNoon + core::DurationFromSeconds(seconds); }

/// A truck 40 m from the origin with every field set.
inline core::ChangedObject Truck(std::uint64_t revision = 1, double last_seen_s = 2.0) {
  core::ChangedObject o;
  o.uid = "truck-1";
  o.revision = revision;
  o.state = revision == 1 ? core::ChangeState::kNew : core::ChangeState::kConfirmed;
  o.box = {.centre_m = {31.25, 25.5, 1.62},
           .size_m = {7.98 + 0.01 * static_cast<double>(revision), 2.21, 3.24},
           .heading_rad = 0.7312};
  for (int i = 0; i < 7; ++i) o.covariance(i, i) = 0.01 * (i + 1) / 3.0;
  o.covariance(0, 6) = o.covariance(6, 0) = -0.00123456789012345;
  o.side_seen = {true, true, false, false, true};
  o.second_heading_rad = 0.7312 + core::kPi / 2;
  o.existence_probability = 0.987654321;
  o.size_class = core::SizeClass::kTruck;
  o.class_probability = 0.83;
  o.voxels = 417;
  o.votes = 81234567890ULL;
  o.last_absent = At(-3600.0 * 24 * 90);
  o.first_seen = At(0.0);
  o.last_seen = At(last_seen_s);
  o.robots = {"rover-1", "rover 2"};
  return o;
}

inline core::ChangedObject Gone(core::ChangedObject o, double gone_s) {
  o.state = core::ChangeState::kGone;
  ++o.revision;
  o.gone = At(gone_s);
  return o;
}

inline core::RoadStation Station(double along_m, double passable_m, double observed_s) {
  core::RoadStation s;
  s.road = "factory road";
  s.along_m = along_m;
  s.left_m = {along_m, 3.0, 0.1};
  s.right_m = {along_m, -3.0, 0.0};
  s.road_width_m = 6.0;
  s.passable_m = passable_m;
  s.passable_sd_m = 0.04;
  s.gap_begin_m = 0.0;
  s.gap_end_m = passable_m;
  s.unknown_share = 0.125;
  s.passable_class = passable_m > 3.0 ? 2 : 0;
  s.observed = At(observed_s);
  return s;
}

inline core::ObjectTextures Textures() {
  core::ObjectTextures t;
  t.width_px = 64;
  t.height_px = 48;
  t.atlas_jpeg = *Jpeg(t.width_px, t.height_px, 500);
  t.faces = {
      {core::BoxSide::kLeft, {{{0, 0}, {40, 0}, {40, 20}, {0, 20}}}, "m1/000012", At(1), 0.875},
      {core::BoxSide::kFront, {{{40, 0}, {64, 0}, {64, 20}, {40, 20}}}, "m1/000012", At(1), 1.0}};
  return t;
}

inline ObjectRegister OpenRegister(const std::string& target,
                                   const core::Geodetic& origin = kOrigin) {
  auto opened = ObjectRegister::Open(
      {.target = target, .origin = origin, .survey = "20261122T120000Z", .who = "rover-1"});
  if (!opened) throw std::runtime_error(opened.error().message);
  return std::move(*opened);
}

/// What sqlite3 answers to a query of a GeoPackage: rows by line, columns by '|'.
inline std::string Sql(const std::filesystem::path& file, const std::string& query) {
  std::string answer = Shell("sqlite3 '" + file.string() + "' \"" + query + "\"");
  while (!answer.empty() && answer.back() == '\n') answer.pop_back();
  return answer;
}

#define ASSERT_OK(expression)                        \
  do {                                               \
    const auto& result_ = (expression);              \
    ASSERT_TRUE(result_) << result_.error().message; \
  } while (false)

}  // namespace kawara::gis::testing
