#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/measurements.hpp"
#include "core/time.hpp"
#include "estimation/error_state.hpp"
#include "estimation/local_frame.hpp"
#include "estimation/nav_types.hpp"
#include "estimation/navigation_config.hpp"
#include "tests/support/drive_path.hpp"

namespace kawara::testing {

/// Instruments on the drive, with errors exactly as the filter models them.
struct DriveSensors {
  estimation::ImuNoise imu;  ///< all zero: perfect
  double imu_hz = 75.0;
  double gnss_hz = 10.0;
  double wheels_hz = 20.0;  ///< 0: none
  Eigen::Vector3d lever_arm_frd_m{0.12, -0.18, -0.92};
  estimation::GnssErrors gnss;
  double position_sd_m = 0.01;  ///< as stated, horizontally; 1.5 times that vertically
  double velocity_sd_mps = 0.05;
  double wheel_sd_mps = 0.03;
  double wheel_turn_sd_radps = 0.03;
  double speed_scale = 0.0;
  double turn_scale = 0.0;
  double time_offset_s = 0.0;  ///< GNSS time minus the stamps of inertial unit and wheels
  double velocity_delay_s = 0.0;
  double noise = 1.0;  ///< of GNSS and wheels; 0: none
};

/// What the filter has to find out.
struct HiddenTruth {
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
};

struct DriveRecording {
  std::vector<estimation::ImuSample> imu;
  std::vector<Truth> truth;         ///< at each of them
  std::vector<HiddenTruth> hidden;  ///< at each of them
  std::vector<core::GnssFix> fixes;
  std::vector<estimation::OdometrySample> wheels;

  /// One sample or measurement, when it comes to hand.
  enum class Kind : std::uint8_t { kFix, kWheels, kImu };
  struct Arrival {
    double t_s = 0.0;
    Kind kind = Kind::kImu;
    std::size_t index = 0;
  };
  /// All of them in order of time, measurements before a sample of the same instant.
  std::vector<Arrival> InOrder() const;
};

inline core::GpsTime DriveTime(double t_s) {
  return core::GpsTime::FromNs(1'400'000'000'000'000'000 + std::llround(t_s * 1e9));
}
inline double DriveSeconds(core::GpsTime t) {
  return static_cast<double>(t.ns() - 1'400'000'000'000'000'000) * 1e-9;
}

inline estimation::NavigationConfig ConfigOf(const DriveSensors& sensors) {
  estimation::NavigationConfig config;
  config.imu = sensors.imu;
  config.lever_arm_frd_m = sensors.lever_arm_frd_m;
  config.gnss = sensors.gnss;
  return config;
}

class Gauss {
 public:
  explicit Gauss(std::uint64_t seed) : random_(seed) {}
  double operator()(double sd) { return sd * normal_(random_); }
  Eigen::Vector3d Three(double sd) {
    const double x = (*this)(sd), y = (*this)(sd), z = (*this)(sd);
    return {x, y, z};
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

inline DriveRecording Record(const DrivePlan& plan, const DriveSensors& sensors,
                             std::uint64_t seed) {
  Gauss gauss(seed);
  const estimation::ImuNoise& unit = sensors.imu;
  HiddenTruth hidden{gauss.Three(unit.gyro_bias_radps), gauss.Three(unit.accel_bias_mps2)};
  const Eigen::Vector3d gyro_scale = gauss.Three(unit.gyro_scale);
  const Eigen::Vector3d accel_scale = gauss.Three(unit.accel_scale);
  const Eigen::Vector3d cross = gauss.Three(unit.gyro_misalignment);
  Eigen::Vector3d coloured = gauss.Three(1.0);
  const double imu_dt_s = 1.0 / sensors.imu_hz;

  enum class What : std::uint8_t { kVelocity, kFix, kWheels, kImu };
  struct Event {
    double t_s;
    What what;
    int number;
  };
  std::vector<Event> events;
  const auto add = [&](double hz, double shift_s, What what) {
    for (int i = 1; hz > 0.0; ++i) {
      const double t_s = static_cast<double>(i) / hz + shift_s;
      if (t_s > plan.duration_s) break;
      if (t_s > 0.0) events.push_back({t_s, what, i});
    }
  };
  add(sensors.gnss_hz, -sensors.velocity_delay_s, What::kVelocity);
  add(sensors.gnss_hz, 0.0, What::kFix);
  add(sensors.wheels_hz, 0.003, What::kWheels);
  add(sensors.imu_hz, 0.0, What::kImu);
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t_s < b.t_s; });

  DrivePath path(plan);
  DriveRecording out;
  DrivePath::Increments sum;
  std::vector<Eigen::Vector3d> velocities_ned;  // of the epochs, each some delay before it
  for (const Event& event : events) {
    const auto step = path.MoveTo(event.t_s);
    sum.angle += step.angle;
    sum.push += step.push;
    const Truth truth = path.Now();
    const Eigen::Matrix3d ned_from_body = truth.ned_from_body.toRotationMatrix();
    switch (event.what) {
      case What::kVelocity: {
        const Eigen::Vector3d turning =
            truth.rate_radps -
            ned_from_body.transpose() * estimation::EarthRateNed(truth.position.lat_rad);
        velocities_ned.resize(static_cast<std::size_t>(event.number), Eigen::Vector3d::Zero());
        velocities_ned.back() =
            truth.velocity_ned_mps + ned_from_body * turning.cross(sensors.lever_arm_frd_m);
        break;
      }
      case What::kFix: {
        const Eigen::Vector3d sd_ned = sensors.position_sd_m * Eigen::Vector3d(1.0, 1.0, 1.5);
        const double keep = std::exp(-1.0 / (sensors.gnss_hz * sensors.gnss.coloured_time_s));
        coloured = keep * coloured + gauss.Three(std::sqrt(1.0 - keep * keep));
        const Eigen::Vector3d error_ned =
            sensors.noise * sd_ned.cwiseProduct(sensors.gnss.white_share * gauss.Three(1.0) +
                                                sensors.gnss.coloured_share * coloured);
        core::GnssFix fix;
        fix.time = DriveTime(event.t_s);
        fix.rtk = core::RtkState::kFixed;
        fix.has_position = true;
        fix.antenna = estimation::Displaced(truth.position,
                                            ned_from_body * sensors.lever_arm_frd_m + error_ned);
        fix.position_cov_enu_m2.diagonal() =
            Eigen::Vector3d(sd_ned.y(), sd_ned.x(), sd_ned.z()).cwiseAbs2();
        fix.has_velocity = true;
        const Eigen::Vector3d v = velocities_ned[static_cast<std::size_t>(event.number - 1)] +
                                  gauss.Three(sensors.noise * sensors.velocity_sd_mps);
        fix.velocity_enu_mps = {v.y(), v.x(), -v.z()};
        fix.velocity_sd_enu_mps.setConstant(sensors.velocity_sd_mps);
        out.fixes.push_back(fix);
        break;
      }
      case What::kWheels: {
        estimation::OdometrySample wheels;
        wheels.time = DriveTime(event.t_s - sensors.time_offset_s);
        wheels.has_turn_rate = true;
        if (truth.speed_mps > 0.0) {  // wheels at rest count nothing
          wheels.speed_mps = (1.0 + sensors.speed_scale) * truth.speed_mps +
                             gauss(sensors.noise * sensors.wheel_sd_mps);
          wheels.turn_rate_radps = (1.0 + sensors.turn_scale) * truth.rate_radps.z() +
                                   gauss(sensors.noise * sensors.wheel_turn_sd_radps);
        }
        out.wheels.push_back(wheels);
        break;
      }
      case What::kImu: {
        estimation::ImuSample sample;
        sample.time = DriveTime(event.t_s - sensors.time_offset_s);
        const double root = std::sqrt(imu_dt_s);
        hidden.gyro_bias_radps += gauss.Three(unit.gyro_bias_rw * root);
        hidden.accel_bias_mps2 += gauss.Three(unit.accel_bias_rw * root);
        Eigen::Vector3d rate = sum.angle / imu_dt_s;
        rate.head<2>() += cross.head<2>() * rate.z();
        sample.rate_radps = rate + gyro_scale.cwiseProduct(rate) + hidden.gyro_bias_radps +
                            gauss.Three(unit.gyro_arw_rad_rts / root);
        const Eigen::Vector3d force = sum.push / imu_dt_s;
        sample.specific_force_mps2 = force + accel_scale.cwiseProduct(force) +
                                     hidden.accel_bias_mps2 +
                                     gauss.Three(unit.accel_vrw_mps_rts / root);
        sum = {};
        out.imu.push_back(sample);
        out.truth.push_back(truth);
        out.hidden.push_back(hidden);
        break;
      }
    }
  }
  return out;
}

inline std::vector<DriveRecording::Arrival> DriveRecording::InOrder() const {
  std::vector<Arrival> order;
  order.reserve(imu.size() + fixes.size() + wheels.size());
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    order.push_back({DriveSeconds(fixes[i].time), Kind::kFix, i});
  }
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const double offset_s = truth[0].t_s - DriveSeconds(imu[0].time);
    order.push_back({DriveSeconds(wheels[i].time) + offset_s, Kind::kWheels, i});
  }
  for (std::size_t i = 0; i < imu.size(); ++i) order.push_back({truth[i].t_s, Kind::kImu, i});
  std::stable_sort(order.begin(), order.end(),
                   [](const Arrival& a, const Arrival& b) { return a.t_s < b.t_s; });
  return order;
}

}  // namespace kawara::testing
