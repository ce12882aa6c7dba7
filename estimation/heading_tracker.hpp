#pragma once
#include <cstdint>

#include "core/geodesy.hpp"
#include "core/time.hpp"

namespace kawara::estimation {

struct HeadingConfig {
  bool use_magnetic = true;  ///< false: the unit's heading is not trusted, gyro and course only
  double declination_rad =
      0.0;  ///< added to magnetic heading, here and nowhere else; east positive
  double magnetic_sigma_rad =
      4.0 * core::kRadFromDeg;  ///< slowly changing error of the compass (steel nearby)
  double magnetic_wander_rad = 1.0 * core::kRadFromDeg;  ///< how fast that changes, per root second
  double gyro_wander_rad = 0.1 * core::kRadFromDeg;   ///< per root second, without magnetic heading
  double course_sigma_rad = 2.0 * core::kRadFromDeg;  ///< side slip: course against heading
  double velocity_floor_mps = 0.1;  ///< receivers' velocities lag and sway by more than they say
  double min_course_speed_mps = 0.7;
  double max_course_rate_radps =
      5.0 * core::kRadFromDeg;  ///< in sharper turns course is not heading
};

/// True heading = reference (magnetic heading plus declination, or integrated gyro) + an offset
/// that one Kalman state follows from course over ground while moving straight, or from a
/// two-antenna heading. A course opposite to the heading is taken for driving backwards. Angles
/// [rad]. Real-time safe, deterministic.
class HeadingTracker {
 public:
  explicit HeadingTracker(const HeadingConfig& config = {});

  const HeadingConfig& config() const { return config_; }
  /// Heading is known: at once with a magnetic reference, else after the first straight run.
  bool known() const { return known_; }
  double offset_rad() const { return offset_rad_; }
  double sigma_rad() const;
  std::int64_t course_updates() const { return course_updates_; }
  std::int64_t course_refused() const { return course_refused_; }

  /// The reference has run on for this long: on magnetic heading (its error drifts about zero) or
  /// on the gyro (the error wanders off).
  void Elapse(double seconds, bool magnetic);
  /// The reference is broken (samples were lost while running on the gyro).
  void LoseReference() { known_ = false; }
  /// Course over ground while the reference stood at `reference_yaw_rad`. Ignored below the minimum
  /// speed. Call it about once a second: its errors (side slip) last that long, more often would
  /// count them as news.
  void AddCourse(double reference_yaw_rad, double course_rad, double speed_mps,
                 double velocity_sigma_mps);
  /// A measured true heading (two antennas).
  void AddHeading(double reference_yaw_rad, double heading_rad, double sigma_rad);

 private:
  void Update(double innovation_rad, double measurement_var);
  void Begin(double offset_rad, double variance);

  const HeadingConfig config_;
  bool known_ = false;
  double offset_rad_ = 0.0;
  double variance_ = 0.0;
  std::int64_t course_updates_ = 0;
  std::int64_t course_refused_ = 0;
  int refused_in_row_ = 0;
};

}  // namespace kawara::estimation
