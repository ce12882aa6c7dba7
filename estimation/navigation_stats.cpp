#include "estimation/navigation_stats.hpp"

#include <algorithm>

namespace kawara::estimation {

const char* ToString(NavSource source) {
  constexpr const char* kNames[kNavSources] = {
      "rtk fixed", "rtk float",   "code",       "velocity",   "two antennas",
      "ahrs",      "wheel speed", "wheel turn", "constraint", "standstill"};
  return kNames[static_cast<std::size_t>(source)];
}

NavigationStats operator+(const NavigationStats& a, const NavigationStats& b) {
  NavigationStats sum = a;
  for (std::size_t i = 0; i < sum.source.size(); ++i) {
    sum.source[i].offered += b.source[i].offered;
    sum.source[i].accepted += b.source[i].accepted;
    sum.source[i].rejected += b.source[i].rejected;
    sum.source[i].nis_sum += b.source[i].nis_sum;
    sum.source[i].nis_dof += b.source[i].nis_dof;
  }
  sum.imu_samples += b.imu_samples;
  sum.imu_duplicates += b.imu_duplicates;
  sum.imu_backwards += b.imu_backwards;
  sum.imu_invalid += b.imu_invalid;
  sum.imu_spikes += b.imu_spikes;
  sum.imu_gaps += b.imu_gaps;
  sum.late_fused += b.late_fused;
  sum.too_late += b.too_late;
  sum.invalid += b.invalid;
  sum.repeated += b.repeated;
  sum.outages += b.outages;
  sum.longest_outage_s = std::max(sum.longest_outage_s, b.longest_outage_s);
  sum.wrong_fix_episodes += b.wrong_fix_episodes;
  sum.resets += b.resets;
  sum.alignments += b.alignments;
  return sum;
}

}  // namespace kawara::estimation
