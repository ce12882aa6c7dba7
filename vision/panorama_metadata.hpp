#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/measurements.hpp"
#include "core/time.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::vision {

/// What a panorama's file says about where, when and which way. Written as EXIF 2.31 (APP1 Exif),
/// Google Photo Sphere XMP (GPano) and a block of our own in the same XMP packet (covariance, RTK
/// state, exact time and height).
struct PanoramaMetadata {
  std::optional<core::UtcTime> time;       ///< middle of the exposure
  std::optional<core::Geodetic> position;  ///< of the camera's centre, WGS 84, ellipsoidal height
  /// Ellipsoidal height minus height above sea level. EXIF knows sea level only: with NaN the
  /// GPSAltitude tag carries the ellipsoidal height and UserComment says so; with a value it
  /// carries the height above the sea.
  double geoid_separation_m = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix3d position_cov_enu_m2 = Eigen::Matrix3d::Zero();  ///< zero: unknown
  core::RtkState rtk = core::RtkState::kNone;
  double gnss_age_s = std::numeric_limits<double>::quiet_NaN();
  double hdop = std::numeric_limits<double>::quiet_NaN();
  /// Of the PICTURE, not the body: yaw = true heading of the image centre, pitch = its elevation,
  /// roll. Equal to the body's attitude for a panorama that was not levelled or turned
  /// (PanoramaUnwrapper::PictureAttitude).
  std::optional<core::Attitude> attitude;
  Eigen::Vector3d attitude_sd_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw; zero: unknown
  PanoramaGeometry geometry;                                  ///< width 0: no GPano block

  std::string make;  ///< empty: tag left out (or kept, when a camera's own file is merged)
  std::string model;
  std::string software = "Kawaraban";
  std::string robot;
  std::string mission;
  std::int64_t epoch = 0;
};

/// Writes `metadata` into the JPEG stream `jpeg` without touching the coded picture; the result
/// replaces the contents of `out` (its capacity is reused). An Exif block and XMP packet that are
/// there already are merged: what `metadata` says wins, everything else (exposure, thumbnail, maker
/// note, other namespaces) stays as it was. An unreadable old block is replaced. Rationals keep
/// 1e-7" (3 um) in position, 0.1 mm in height, 0.1 us in time, 1e-4 deg in heading. kFormat: not a
/// JPEG stream. Pure function: same input, same bytes.
core::Expected<void> InsertPanoramaMetadata(std::span<const std::uint8_t> jpeg,
                                            const PanoramaMetadata& metadata,
                                            std::vector<std::uint8_t>* out);

/// The same for a re-encoded picture: old blocks are taken from `original`, the picture from
/// `jpeg`.
core::Expected<void> InsertPanoramaMetadata(std::span<const std::uint8_t> jpeg,
                                            std::span<const std::uint8_t> original,
                                            const PanoramaMetadata& metadata,
                                            std::vector<std::uint8_t>* out);

/// Reads what is there; a picture without any gives an object of empty optionals. Our own block is
/// preferred to the coarser standard tags. Width and height come from GPano if present, and are not
/// compared with the picture. kFormat: not a JPEG stream. Damaged blocks count as absent. Never
/// throws on bad bytes.
core::Expected<PanoramaMetadata> ReadPanoramaMetadata(std::span<const std::uint8_t> jpeg);

/// 32 hex digits that are the same for the same picture of the same mission and differ otherwise
/// (ImageUniqueID).
std::string ImageUniqueId(const PanoramaMetadata& metadata);

}  // namespace kawara::vision
