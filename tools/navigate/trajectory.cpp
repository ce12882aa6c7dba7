#include "tools/navigate/trajectory.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

/// ",value" as printf's "%.*f" writes it, five times as fast: there are nineteen in a row.
void AppendFixed(std::string& line, double value, int digits) {
  std::array<char, 400> text{};  // the largest double has 309 digits before the point
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value,
                                          std::chars_format::fixed, digits);
  line += ',';
  line.append(text.data(), error == std::errc() ? end : text.data());
}

}  // namespace

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
  constexpr int kDegDigits = 10;  // 0.01 mm
  constexpr int kDigits = 4;
  constexpr int kSdDigits = 5;
  const auto put = [this](double value, int digits) { AppendFixed(line_, value, digits); };
  line_ = FormatSeconds(p.time);
  put(p.position.lat_rad * core::kDegFromRad, kDegDigits);
  put(p.position.lon_rad * core::kDegFromRad, kDegDigits);
  put(p.position.h_ellipsoidal_m, kDigits);
  for (const double v : p.velocity_ned_mps) put(v, kDigits);
  put(p.attitude.roll_rad * core::kDegFromRad, kDigits);
  put(p.attitude.pitch_rad * core::kDegFromRad, kDigits);
  const double yaw_deg = p.attitude.yaw_rad * core::kDegFromRad;
  put(yaw_deg < 0.0 ? yaw_deg + 360.0 : yaw_deg, kDigits);
  for (const double sd_m : p.position_sd_ned_m) put(sd_m, kSdDigits);
  for (const double sd_mps : p.velocity_sd_ned_mps) put(sd_mps, kSdDigits);
  for (const double sd_rad : p.attitude_sd_rad) put(sd_rad * core::kDegFromRad, kSdDigits);
  line_.append(",").append(ToString(p.state)).append(",").append(ToString(p.reason)).append("\n");
  ++rows_;
  return file_.Write(line_);
}

}  // namespace kawara::navigate
