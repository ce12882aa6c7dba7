#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/measurements.hpp"
#include "estimation/gps_timeline.hpp"
#include "estimation/heading_tracker.hpp"
#include "estimation/history.hpp"

namespace kawara::estimation {

struct PoseComposerConfig {
  /// From the body's reference point to the GNSS antenna, forward, right, down [m].
  Eigen::Vector3d lever_arm_frd_m = Eigen::Vector3d::Zero();
  HeadingConfig heading;
  double roll_pitch_sigma_rad =
      2.0 * core::kRadFromDeg;  ///< of the unit's own attitude while moving
  double level_sigma_rad =
      5.0 * core::kRadFromDeg;     ///< of "level" where the unit gives no attitude
  double gyro_sigma_radps = 0.02;  ///< growth of attitude beyond the last sample, per second
  double acceleration_sigma_mps2 =
      1.0;  ///< what the vehicle does between fixes that nobody measured
  core::Duration max_interpolation =
      core::Milliseconds(2500);  ///< longest gap of fixes bridged from both sides
  core::Duration max_extrapolation = core::Seconds(2);  ///< beyond the last fix
  core::Duration max_attitude_gap =
      core::Milliseconds(300);  ///< between or beyond attitude samples
  core::Duration max_lateness =
      core::Seconds(1);  ///< fixes older than the newest by more are refused
};

/// The pose of the robot from GNSS fixes and the attitude unit, until a navigation filter replaces
/// it: the position interpolated between fixes (cubic, by their velocities) or carried on along the
/// arc the gyro shows; the attitude interpolated on SO(3) and carried on by the gyro; heading by
/// HeadingTracker; antenna brought to the reference point by the lever arm. No smoothing: it is as
/// good as the fixes are, and says so in the covariance, where the uncertainty of time enters as
/// velocity times sigma.
///
/// Any instant inside the buffered window (about 4 s of attitude at 120 Hz, 6 s of fixes at 10 Hz)
/// can be asked for, again and again; a late fix is put in its place. Real-time safe: fixed memory.
/// Deterministic. One thread.
class PoseComposer {
 public:
  explicit PoseComposer(const PoseComposerConfig& config = {});

  /// A fix without position only ends nothing and helps nothing; it is counted as empty.
  void AddFix(const core::GnssFix& fix, const GpsTimeline& clock);
  void AddAhrs(const core::AhrsSample& sample);
  /// AddAhrs, and the pose at that sample: the real-time output at the unit's rate.
  core::Pose AddAhrsAndCompose(const core::AhrsSample& sample, const GpsTimeline& clock);

  /// `valid` is false (and the rest as far as known) when the clock, the position or the heading is
  /// missing.
  core::Pose At(core::MonoTime t, const GpsTimeline& clock) const;
  core::Pose At(core::GpsTime t, const GpsTimeline& clock) const;

  struct Stats {
    std::int64_t fixes = 0;
    std::int64_t fixes_empty = 0;
    std::int64_t fixes_late_inserted = 0;
    std::int64_t fixes_too_late = 0;
    std::int64_t fixes_repeated = 0;
    std::int64_t ahrs = 0;
    std::int64_t ahrs_out_of_order = 0;
  };
  const Stats& stats() const { return stats_; }
  const HeadingTracker& heading() const { return heading_; }

 private:
  struct AttitudeSample {
    core::MonoTime time;
    Eigen::Quaterniond ned_body =
        Eigen::Quaterniond::Identity();  ///< yaw: the tracker's reference heading
    Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
    bool has_attitude = false;  ///< roll and pitch are the unit's, not just "level"
  };
  struct AttitudeAt {
    Eigen::Quaterniond ned_body = Eigen::Quaterniond::Identity();
    Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
    Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();
    bool known = false;
  };
  struct PositionAt {
    core::Geodetic antenna;
    Eigen::Vector3d velocity_enu_mps = Eigen::Vector3d::Zero();
    Eigen::Matrix3d cov_enu_m2 = Eigen::Matrix3d::Zero();
    core::RtkState rtk = core::RtkState::kNone;
    double age_s = 0.0;
    bool known = false;
  };

  void UpdateHeading(const core::GnssFix& fix, const GpsTimeline& clock);
  AttitudeAt AttitudeOf(core::MonoTime t) const;
  /// Heading at t as far as the attitude history goes.
  std::optional<double> YawAt(core::MonoTime t) const;
  PositionAt PositionOf(core::GpsTime t, const GpsTimeline& clock) const;
  PositionAt Between(std::size_t first, core::GpsTime t) const;
  PositionAt Beyond(std::size_t last, core::GpsTime t, const GpsTimeline& clock) const;
  /// Of one fix; from its neighbour before if the receiver gave none.
  struct Velocity {
    Eigen::Vector3d enu_mps = Eigen::Vector3d::Zero();
    Eigen::Vector3d sd_mps = Eigen::Vector3d::Zero();
    bool known = false;
  };
  Velocity VelocityOf(std::size_t fix) const;
  core::Pose Compose(core::GpsTime gps, core::MonoTime mono, double time_sigma_s,
                     const GpsTimeline& clock) const;

  const PoseComposerConfig config_;
  HeadingTracker heading_;
  History<core::GnssFix, 64> fixes_;        ///< with position only, ascending time
  History<AttitudeSample, 512> attitudes_;  ///< ascending time
  double reference_yaw_rad_ = 0.0;          ///< of the newest attitude sample
  core::GpsTime last_course_;
  int too_late_in_row_ = 0;
  int backwards_in_row_ = 0;
  Stats stats_;
};

}  // namespace kawara::estimation
