#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "onboard/survey/survey_config.hpp"

namespace kawara::survey {

/// One line of a table of poses.
struct PoseRow {
  std::string name;    ///< of column `frame` or `file`; empty: there was none
  std::string camera;  ///< of column `camera`; empty: of every camera
  /// Not set: no stamp. Of stamps in seconds of an unnamed clock only differences mean something.
  core::GpsTime time;
  Eigen::Isometry3d map_from_body = Eigen::Isometry3d::Identity();
  /// Of the position in map axes [m^2], then of small turns about the body's axes [rad^2].
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  bool has_covariance = false;
};

struct PoseTable {
  std::vector<PoseRow> rows;
  /// Of the map (its axes then are east, north, up there) where poses are geodetic: as asked for,
  /// else the first row's place. Empty: the map is the file's own frame.
  std::optional<core::Geodetic> origin;
  int rows_without_place = 0;  ///< left out: all their place's columns are empty or "nan"
};

/// Reads poses: CSV with a header of names in any order (fields parted by commas, or by semicolons
/// with a decimal comma or point; in quotes or not), or TUM lines "t x y z qx qy qz qw".
///   place     lat_deg lon_deg h_ellipsoidal_m (or h_m, h)   or   x y z (or x_m y_m z_m)
///   attitude  qw qx qy qz (map_from_body), or roll_deg pitch_deg yaw_deg
///   stamp     gps_ns, t_ns, t, t_s or time_s;   name frame or file;   camera
///   deviation sd_east_m sd_north_m sd_up_m or sd_x_m sd_y_m sd_z_m or sd_position_m;
///             sd_attitude_deg or sd_roll_deg sd_pitch_deg sd_yaw_deg
/// Roll, pitch, yaw with geodetic places are those of forward-right-down axes against north-east-
/// down; with metric ones ZYX of forward-left-up axes in the map, yaw counterclockwise from x. They
/// become a pose of `body` axes; quaternions are taken as they are. Other columns are passed over.
/// Errors: kFormat, "source:line: what".
core::Expected<PoseTable> ParsePoses(std::string_view text, const std::string& source,
                                     BodyAxes body,
                                     const std::optional<core::Geodetic>& origin = {});

}  // namespace kawara::survey
