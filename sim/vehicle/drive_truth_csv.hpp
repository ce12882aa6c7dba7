#pragma once
#include <filesystem>

#include "core/expected.hpp"
#include "sim/vehicle/simulate_drive.hpp"

namespace kawara::sim {

/// Writes a simulated drive's truth into a folder (made if missing), for whoever checks us:
///   truth_trajectory.csv  gps_ns,lat_deg,lon_deg,h_ellipsoidal_m,roll_deg,pitch_deg,yaw_deg,
///                         east_m,north_m,up_m,v_east_mps,v_north_mps,v_up_mps,
///                         rate_x_degps,rate_y_degps,rate_z_degps
///       the body's reference point; attitude true (against north at its own place); ENU of the
///       site's origin; rates of the body against the ENU axes in body axes, `rate_hz` rows a
///       second
///   truth_gnss.csv gps_ns,state,wrong_fix,satellites,blocked_share,hdop,vdop,lat_deg,lon_deg,
///                         h_ellipsoidal_m,error_north_m,error_east_m,error_down_m
///       every epoch of the receiver: the antenna's true place and how far off the fix was
///   truth_odometry.csv    gps_ns,stamp_ns,left_ticks,right_ticks,left_mps,right_mps,true_left_m,
///                         true_right_m,slipping
///       what the wheel encoders said (stamp_ns on their own clock) beside the way really made
///   truth_imu_bias.csv    gps_ns,gyro_x_degph,gyro_y_degph,gyro_z_degph,accel_x_mg,accel_y_mg,
///                         accel_z_mg
/// The first is read by kawara-evaluate as it is. Errors: kIo, kPermission with the file.
core::Expected<void> WriteDriveTruth(const DriveTruth& truth, const std::filesystem::path& folder,
                                     double rate_hz = 100.0);

}  // namespace kawara::sim
