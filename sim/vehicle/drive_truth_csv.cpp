#include "sim/vehicle/drive_truth_csv.hpp"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

namespace kawara::sim {
namespace {

constexpr double kDeg = core::kDegFromRad;

/// A CSV file being written; whether all went well is asked at the end.
class Csv {
 public:
  static core::Expected<Csv> Create(const std::filesystem::path& file, const char* header) {
    Csv csv(file.string(), std::fopen(file.c_str(), "we"));
    if (!csv.out_) return tl::unexpected(core::ErrnoError("create " + csv.name_, errno));
    std::fprintf(csv.out_.get(), "%s\n", header);
    return csv;
  }
  std::FILE* out() { return out_.get(); }
  core::Expected<void> Close() {
    const bool good = std::ferror(out_.get()) == 0;
    if (std::fclose(out_.release()) != 0 || !good)
      return tl::unexpected(core::ErrnoError("write " + name_, errno));
    return {};
  }

 private:
  Csv(std::string name, std::FILE* out) : name_(std::move(name)), out_(out, std::fclose) {}
  std::string name_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> out_;
};

long long Ns(core::GpsTime t) { return static_cast<long long>(t.ns()); }

core::Expected<void> WriteTrajectory(const Trajectory& trajectory,
                                     const std::filesystem::path& file, double rate_hz) {
  core::Expected<Csv> csv = Csv::Create(
      file,
      "gps_ns,lat_deg,lon_deg,h_ellipsoidal_m,roll_deg,pitch_deg,yaw_deg,east_m,north_m,"
      "up_m,v_east_mps,v_north_mps,v_up_mps,rate_x_degps,rate_y_degps,rate_z_degps");
  if (!csv) return tl::unexpected(csv.error());
  const core::Duration step = core::DurationFromSeconds(1.0 / rate_hz);
  for (core::GpsTime t = trajectory.begin(); t <= trajectory.end(); t += step) {
    const core::Geodetic place = trajectory.GeodeticAt(t, Eigen::Vector3d::Zero());
    const core::Attitude attitude = trajectory.AttitudeAt(t);
    const MotionState s = trajectory.At(t);
    const Eigen::Vector3d rate = s.rate_body_radps * kDeg;
    std::fprintf(
        csv->out(),
        "%lld,%.11f,%.11f,%.5f,%.6f,%.6f,%.6f,%.5f,%.5f,%.5f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n",
        Ns(t), place.lat_rad * kDeg, place.lon_rad * kDeg, place.h_ellipsoidal_m,
        attitude.roll_rad * kDeg, attitude.pitch_rad * kDeg, attitude.yaw_rad * kDeg,
        s.position_enu_m.x(), s.position_enu_m.y(), s.position_enu_m.z(), s.velocity_enu_mps.x(),
        s.velocity_enu_mps.y(), s.velocity_enu_mps.z(), rate.x(), rate.y(), rate.z());
  }
  return csv->Close();
}

core::Expected<void> WriteGnss(const std::vector<GnssEpochTruth>& epochs,
                               const std::filesystem::path& file) {
  core::Expected<Csv> csv =
      Csv::Create(file,
                  "gps_ns,state,wrong_fix,satellites,blocked_share,hdop,vdop,lat_deg,lon_deg,"
                  "h_ellipsoidal_m,error_north_m,error_east_m,error_down_m");
  if (!csv) return tl::unexpected(csv.error());
  for (const GnssEpochTruth& e : epochs) {
    std::fprintf(csv->out(), "%lld,%s,%d,%d,%.3f,%.3f,%.3f,%.11f,%.11f,%.5f,%.5f,%.5f,%.5f\n",
                 Ns(e.time), core::ToString(e.rtk), e.wrong_fix ? 1 : 0, e.satellites,
                 e.blocked_share, e.hdop, e.vdop, e.antenna.lat_rad * kDeg,
                 e.antenna.lon_rad * kDeg, e.antenna.h_ellipsoidal_m, e.error_ned_m.x(),
                 e.error_ned_m.y(), e.error_ned_m.z());
  }
  return csv->Close();
}

core::Expected<void> WriteOdometry(const std::vector<OdometrySample>& samples,
                                   const std::filesystem::path& file) {
  core::Expected<Csv> csv = Csv::Create(file,
                                        "gps_ns,stamp_ns,left_ticks,right_ticks,left_mps,right_mps,"
                                        "true_left_m,true_right_m,slipping");
  if (!csv) return tl::unexpected(csv.error());
  for (const OdometrySample& s : samples) {
    std::fprintf(csv->out(), "%lld,%lld,%lld,%lld,%.5f,%.5f,%.5f,%.5f,%d\n", Ns(s.time),
                 Ns(s.stamp), static_cast<long long>(s.left_ticks),
                 static_cast<long long>(s.right_ticks), s.left_mps, s.right_mps, s.true_left_m,
                 s.true_right_m, s.slipping ? 1 : 0);
  }
  return csv->Close();
}

core::Expected<void> WriteBiases(const std::vector<ImuBiasTruth>& biases,
                                 const std::filesystem::path& file) {
  constexpr double kDegph = kDeg * 3600.0;
  constexpr double kMilliG = 1e3 / 9.80665;
  core::Expected<Csv> csv = Csv::Create(
      file, "gps_ns,gyro_x_degph,gyro_y_degph,gyro_z_degph,accel_x_mg,accel_y_mg,accel_z_mg");
  if (!csv) return tl::unexpected(csv.error());
  for (const ImuBiasTruth& b : biases) {
    const Eigen::Vector3d gyro = b.gyro_radps * kDegph;
    const Eigen::Vector3d accel = b.accel_mps2 * kMilliG;
    std::fprintf(csv->out(), "%lld,%.4f,%.4f,%.4f,%.5f,%.5f,%.5f\n", Ns(b.time), gyro.x(), gyro.y(),
                 gyro.z(), accel.x(), accel.y(), accel.z());
  }
  return csv->Close();
}

}  // namespace

core::Expected<void> WriteDriveTruth(const DriveTruth& truth, const std::filesystem::path& folder,
                                     double rate_hz) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return core::Fail(core::ErrorCode::kIo, "folder " + folder.string() + ": " + error.message());
  core::Expected<void> done =
      WriteTrajectory(truth.trajectory, folder / "truth_trajectory.csv", rate_hz);
  if (done) done = WriteGnss(truth.epochs, folder / "truth_gnss.csv");
  if (done) done = WriteOdometry(truth.odometry, folder / "truth_odometry.csv");
  if (done) done = WriteBiases(truth.biases, folder / "truth_imu_bias.csv");
  return done;
}

}  // namespace kawara::sim
