#include "tools/navigate/trajectory.hpp"

#include <array>
#include <cstdio>
#include <utility>

#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {

TrajectoryPoint TrajectoryPoint::Of(const estimation::NavSolution& solution) {
  return {solution.time,
          solution.position,
          solution.velocity_ned_mps,
          solution.attitude,
          solution.position_sd_ned_m(),
          solution.velocity_sd_ned_mps(),
          solution.attitude_sd_rad(),
          solution.state,
          solution.reason};
}

core::Expected<TrajectoryFile> TrajectoryFile::Create(const std::string& path) {
  auto file = SafeFile::Create(path);
  if (!file) return tl::unexpected(file.error());
  const auto ok = file->Write(
      "t,lat,lon,h,vN,vE,vD,roll,pitch,yaw,sd_n,sd_e,sd_d,sd_vN,sd_vE,sd_vD,sd_roll,sd_pitch,sd_"
      "yaw,"
      "state,reason\n");
  if (!ok) return tl::unexpected(ok.error());
  return TrajectoryFile(std::move(*file));
}

core::Expected<void> TrajectoryFile::Add(const TrajectoryPoint& p) {
  const double yaw_deg = p.attitude.yaw_rad * core::kDegFromRad;
  const Eigen::Vector3d attitude_sd_deg = p.attitude_sd_rad * core::kDegFromRad;
  std::array<char, 512> line{};
  const int length = std::snprintf(
      line.data(), line.size(),
      "%s,%.10f,%.10f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,"
      "%.5f,%s,%s\n",
      FormatSeconds(p.time).c_str(), p.position.lat_rad * core::kDegFromRad,
      p.position.lon_rad * core::kDegFromRad, p.position.h_ellipsoidal_m, p.velocity_ned_mps.x(),
      p.velocity_ned_mps.y(), p.velocity_ned_mps.z(), p.attitude.roll_rad * core::kDegFromRad,
      p.attitude.pitch_rad * core::kDegFromRad, yaw_deg < 0.0 ? yaw_deg + 360.0 : yaw_deg,
      p.position_sd_ned_m.x(), p.position_sd_ned_m.y(), p.position_sd_ned_m.z(),
      p.velocity_sd_ned_mps.x(), p.velocity_sd_ned_mps.y(), p.velocity_sd_ned_mps.z(),
      attitude_sd_deg.x(), attitude_sd_deg.y(), attitude_sd_deg.z(), ToString(p.state),
      ToString(p.reason));
  ++rows_;
  return file_.Write({line.data(), static_cast<std::size_t>(length)});
}

}  // namespace kawara::navigate
