#include "sim/vehicle/simulate_drive.hpp"

#include <cmath>

#include "sim/vehicle/imu_errors.hpp"
#include "sim/vehicle/instrument_clock.hpp"
#include "sim/vehicle/random_processes.hpp"

namespace kawara::sim {
namespace {

RecordingSite SiteOf(const DriveScenario& scenario) {
  const ImuConfig& imu = scenario.robot.sensors.imu;
  const MagnetometerConfig& magnetic = scenario.robot.sensors.magnetometer;
  RecordingSite site;
  site.gps_week = core::ToWeek(scenario.begin).week;
  site.imu_late_s = imu.delay_s + 0.5 / imu.rate_hz;
  site.geoid_m = scenario.robot.sensors.gnss.geoid_m;
  site.declination_rad = magnetic.declination_deg * core::kRadFromDeg;
  site.dip_rad = magnetic.dip_deg * core::kRadFromDeg;
  site.field_gauss = magnetic.field_gauss;
  return site;
}

void MeasureInertial(const DriveScenario& scenario, const std::vector<SteelObject>& steel,
                     SimulatedDrive& drive) {
  const ImuConfig& config = scenario.robot.sensors.imu;
  const Eigen::Vector3d& lever = scenario.robot.vehicle.ahrs_frd_m;
  const Trajectory& trajectory = drive.truth.trajectory;
  ImuErrors errors(config, SeedOf(scenario.seed, "imu"));
  Magnetometer magnetometer(scenario.robot.sensors.magnetometer, steel,
                            SeedOf(scenario.seed, "magnetometer"));
  InstrumentClock clock(config.clock, 1.0 / config.rate_hz, SeedOf(scenario.seed, "imu clock"));
  const core::Duration delay = core::DurationFromSeconds(config.delay_s);
  const double end_s = core::ToSeconds(trajectory.end() - trajectory.begin());
  double from_s = clock.true_s() - clock.period_s();
  double next_bias_s = 0.0;
  for (; clock.true_s() <= end_s; clock.Next()) {
    const double to_s = clock.true_s();
    const Inertial measured =
        errors.Apply(MeanInertial(trajectory, lever, from_s, to_s), to_s - from_s);
    RecordedImu& sample = drive.recording.imu.emplace_back();
    sample.time = trajectory.begin() + core::DurationFromSeconds(to_s) + delay;
    sample.rate_radps = measured.rate_radps;
    sample.specific_force_mps2 = measured.specific_force_mps2;
    sample.magnetic_gauss =
        magnetometer.Measure(trajectory.AtSeconds(0.5 * (from_s + to_s)), lever);
    if (to_s >= next_bias_s) {
      drive.truth.biases.push_back(
          {sample.time, errors.gyro_bias_radps(), errors.accel_bias_mps2()});
      next_bias_s += 1.0;
    }
    from_s = to_s;
  }
}

void MeasureGnss(const DriveScenario& scenario, const SkyBlocked& blocked, SimulatedDrive& drive) {
  const GnssConfig& config = scenario.robot.sensors.gnss;
  const Eigen::Vector3d& lever = scenario.robot.vehicle.antenna_frd_m;
  const Trajectory& trajectory = drive.truth.trajectory;
  GnssModel model(config, blocked, SeedOf(scenario.seed, "gnss"));
  const core::Duration period = core::DurationFromSeconds(1.0 / config.rate_hz);
  Eigen::Vector3d last_enu_m = trajectory.AtSeconds(0.0).PointEnu(lever);
  for (core::GpsTime t = trajectory.begin(); t <= trajectory.end(); t += period) {
    const MotionState state = trajectory.At(t);
    const Eigen::Vector3d antenna_enu_m = state.PointEnu(lever);
    const GnssModel::Epoch epoch = model.Next(core::ToSeconds(t - trajectory.begin()),
                                              antenna_enu_m, (antenna_enu_m - last_enu_m).norm());
    last_enu_m = antenna_enu_m;
    const core::Geodetic antenna = trajectory.GeodeticAt(t, lever);
    RecordedFix& fix = drive.recording.fixes.emplace_back();
    fix.time = t;
    fix.antenna = core::OffsetNed(antenna, epoch.error_ned_m);
    fix.sd_ned_m = epoch.sd_ned_m;
    fix.rtk = epoch.rtk;
    fix.satellites = epoch.satellites;
    fix.velocity_ned_mps = trajectory.RotationNedFromEnu(antenna) * state.PointVelocityEnu(lever) +
                           epoch.velocity_error_ned_mps;
    fix.velocity_sd_ned_mps = epoch.velocity_sd_ned_mps;
    drive.truth.epochs.push_back({t, epoch.rtk, epoch.wrong_fix, epoch.satellites,
                                  epoch.blocked_share, epoch.hdop, epoch.vdop, antenna,
                                  epoch.error_ned_m});
  }
}

}  // namespace

core::Expected<SimulatedDrive> SimulateDrive(const DriveScenario& scenario,
                                             const Surroundings& surroundings) {
  const VehicleConfig& vehicle = scenario.robot.vehicle;
  core::Expected<Trajectory> trajectory =
      Trajectory::Make(vehicle, scenario.path, scenario.origin, scenario.begin,
                       surroundings.ground_height_m, SeedOf(scenario.seed, "vibration"));
  if (!trajectory) return tl::unexpected(trajectory.error());
  if (trajectory->end() - trajectory->begin() > core::kDay) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "path: takes more than a day; raise speed_mps or shorten it");
  }
  SimulatedDrive drive{{SiteOf(scenario), {}, {}}, {*trajectory, {}, {}, {}}};
  MeasureInertial(scenario, surroundings.steel, drive);
  MeasureGnss(scenario, surroundings.blocked, drive);
  drive.truth.odometry = MeasureOdometry(*trajectory, vehicle, scenario.robot.sensors.odometry,
                                         SeedOf(scenario.seed, "odometry"));
  return drive;
}

}  // namespace kawara::sim
