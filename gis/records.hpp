#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/measurements.hpp"
#include "core/time.hpp"

/// What the spatial temporal store takes in: plain rows, already in the units of the files
/// (degrees, metres). A figure nobody knows is NaN and becomes NULL in the store. Every row names
/// its robot and its mission.
namespace kawara::gis {

/// Where the reference point was and how it stood, with its accuracy. WGS 84, ellipsoidal height,
/// true heading.
struct PoseFields {
  core::GpsTime time;  ///< instant of validity: the beginning of the row's existence
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  double h_ellipsoidal_m = 0.0;
  double roll_deg = 0.0;
  double pitch_deg = 0.0;
  double yaw_deg = 0.0;
  std::array<double, 3> velocity_enu_mps{};
  std::array<double, 3> position_sd_enu_m{};
  std::array<double, 3> attitude_sd_deg{};  ///< roll, pitch, yaw
  core::RtkState rtk = core::RtkState::kNone;
  double gnss_age_s = 0.0;
};

/// A row of obs_pose. Key: robot, mission, time.
struct PoseRecord {
  std::string robot;
  std::string mission;
  PoseFields pose;
  bool at_exposure =
      false;  ///< the pose of a picture; wins over a periodic one of the same instant
};

enum class PictureStage : std::uint8_t { kPreview = 0, kFull = 1 };

/// A row of obs_panorama and its picture. Key: robot, mission, epoch.
struct PanoramaRecord {
  std::string robot;
  std::string mission;
  std::int64_t epoch = 0;  ///< exposures counted from 1 in the mission
  PictureStage stage = PictureStage::kPreview;
  core::PictureReason reason = core::PictureReason::kEveryEpochs;
  bool has_position = true;  ///< false: the time is known, the place is not (NULL geometry)
  PoseFields pose;           ///< of the camera's centre at mid-exposure
  std::string projection;    ///< as XMP GPano names it
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::shared_ptr<const std::vector<std::uint8_t>> jpeg;
};

/// A row of event_log: attributes without a place. Key: robot, mission, mono, name, text.
struct EventRecord {
  std::string robot;
  std::string mission;
  core::MonoTime mono;  ///< on the robot's clock
  core::GpsTime time;   ///< not set: the robot had no time yet
  int severity = 0;     ///< 0 info, 1 warn-low, 2 warn-high, 3 fatal
  std::string name;
  std::string text;
  std::int64_t suppressed = 0;
};

}  // namespace kawara::gis
