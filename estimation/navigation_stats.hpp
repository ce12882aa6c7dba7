#pragma once
#include <array>
#include <cstdint>

namespace kawara::estimation {

/// Who corrected the filter.
enum class NavSource : std::uint8_t {
  kFixed = 0,   ///< RTK fixed positions
  kFloat,       ///< RTK float positions
  kCode,        ///< DGPS and autonomous positions
  kVelocity,    ///< GNSS velocity
  kHeading,     ///< two antennas
  kAhrs,        ///< the unit's own roll, pitch and magnetic heading
  kSpeed,       ///< wheel speed
  kTurnRate,    ///< wheel turn rate
  kConstraint,  ///< non-holonomic: no motion sideways and upwards
  kStandstill,  ///< zero velocity and zero rate
};
constexpr int kNavSources = 10;
const char* ToString(NavSource source);

/// Innovations of one source, as the filter met them before each update.
struct SourceStats {
  std::int64_t offered = 0;
  std::int64_t accepted = 0;
  std::int64_t rejected = 0;  ///< by gate, trust or hysteresis
  double nis_sum = 0.0;       ///< of accepted ones
  std::int64_t nis_dof = 0;   ///< NIS per degree of freedom = nis_sum / nis_dof, 1 if consistent
};

/// Counts since the start. What was done again for a late measurement is counted once.
struct NavigationStats {
  std::array<SourceStats, kNavSources> source{};
  std::int64_t imu_samples = 0;
  std::int64_t imu_duplicates = 0;
  std::int64_t imu_backwards = 0;
  std::int64_t imu_invalid = 0;  ///< NaN or beyond the range
  std::int64_t imu_spikes = 0;   ///< replaced by the sample before
  std::int64_t imu_gaps = 0;
  std::int64_t late_fused = 0;  ///< measurements older than the newest inertial sample
  std::int64_t too_late = 0;    ///< older than max_lateness: refused
  std::int64_t invalid = 0;     ///< measurements with NaN or nonsense
  std::int64_t repeated = 0;    ///< measurements that had come already
  std::int64_t outages = 0;     ///< times without a believed position for longer than a second
  double longest_outage_s = 0.0;
  std::int64_t wrong_fix_episodes = 0;  ///< fixes that contradicted the prediction
  std::int64_t resets = 0;              ///< gave in to contradicting fixes that stayed
  std::int64_t alignments = 0;
};

/// Counts of one stretch of navigation and the next.
NavigationStats operator+(const NavigationStats& a, const NavigationStats& b);

}  // namespace kawara::estimation
