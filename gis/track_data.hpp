#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/measurements.hpp"

/// What a map shows, read from a store. Inside gis/ only.
namespace kawara::gis {

struct TrackPoint {
  core::GpsTime time;
  core::Geodetic position;
  core::RtkState rtk = core::RtkState::kNone;
};

struct PicturePoint {
  core::GpsTime time;
  core::Geodetic position;
  double yaw_deg = 0.0;
  bool full = false;
};

/// One robot in one mission, in the order of time.
struct MissionTrack {
  std::string robot;
  std::string mission;
  std::vector<TrackPoint> poses;
  std::vector<PicturePoint> pictures;
  double length_m = 0.0;
};

/// Errors: kNotFound, those of opening a store.
core::Expected<std::vector<MissionTrack>> LoadTracks(const std::string& store);

}  // namespace kawara::gis
