#include "tools/navigate/run_summary.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

/// Adds a line.
[[gnu::format(printf, 2, 3)]] void Line(std::string& out, const char* format, ...) {
  std::array<char, 256> text{};
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  out.append(text.data(), std::min(static_cast<std::size_t>(std::max(length, 0)), text.size() - 1));
  out += '\n';
}

long long Count(std::int64_t n) { return static_cast<long long>(n); }

void SourceTable(std::string& out, const estimation::NavigationStats& stats) {
  Line(out, "%-12s %9s %9s %9s %9s", "source", "offered", "accepted", "rejected", "NIS/dof");
  for (int i = 0; i < estimation::kNavSources; ++i) {
    const estimation::SourceStats& s = stats.source[static_cast<std::size_t>(i)];
    if (s.offered == 0) continue;
    std::array<char, 16> nis{'-'};
    if (s.nis_dof > 0) {
      std::snprintf(nis.data(), nis.size(), "%.2f", s.nis_sum / static_cast<double>(s.nis_dof));
    }
    Line(out, "%-12s %9lld %9lld %9lld %9s", ToString(static_cast<estimation::NavSource>(i)),
         Count(s.offered), Count(s.accepted), Count(s.rejected), nis.data());
  }
}

void Events(std::string& out, const estimation::NavigationStats& s) {
  Line(out, "outages %lld (longest %.1f s), wrong-fix episodes %lld, resets %lld, alignments %lld",
       Count(s.outages), s.longest_outage_s, Count(s.wrong_fix_episodes), Count(s.resets),
       Count(s.alignments));
  Line(out, "late fused %lld, too late %lld, repeated %lld, invalid %lld", Count(s.late_fused),
       Count(s.too_late), Count(s.repeated), Count(s.invalid));
  Line(out,
       "IMU %lld samples: %lld duplicates, %lld backwards, %lld invalid, %lld spikes, %lld gaps",
       Count(s.imu_samples), Count(s.imu_duplicates), Count(s.imu_backwards), Count(s.imu_invalid),
       Count(s.imu_spikes), Count(s.imu_gaps));
}

void Calibration(std::string& out, const RunSummary& summary) {
  if (!summary.found) {
    Line(out, "the solution is not aligned at the end: nothing found out about the sensors");
    return;
  }
  const CalibrationFound& c = *summary.found;
  Line(out, "time offset %+.4f s (sd %.4f), to be added to IMU stamps", c.time_offset_s.value,
       c.time_offset_s.sd);
  if (summary.wheels) {
    Line(out, "wheel scales: speed %+.2f %% (sd %.2f), turn %+.1f %% (sd %.1f)",
         100.0 * c.speed_scale.value, 100.0 * c.speed_scale.sd, 100.0 * c.turn_scale.value,
         100.0 * c.turn_scale.sd);
  }
  Line(out, "mounting: pitch %+.2f deg (sd %.2f), yaw %+.2f deg (sd %.2f)", c.mount_pitch_deg.value,
       c.mount_pitch_deg.sd, c.mount_yaw_deg.value, c.mount_yaw_deg.sd);
  Line(out, "gyro bias %+.4f %+.4f %+.4f deg/s, accelerometer bias %+.3f %+.3f %+.3f m/s^2",
       c.gyro_bias_degps[0].value, c.gyro_bias_degps[1].value, c.gyro_bias_degps[2].value,
       c.accel_bias_mps2[0].value, c.accel_bias_mps2[1].value, c.accel_bias_mps2[2].value);
}

void HeldOut(std::string& out, const char* which, const char* state, const ErrorSum& sum) {
  if (sum.count == 0) return;
  const Eigen::Vector3d rms = sum.RmsNed();
  Line(out, "held out, %s, %s: RMS N/E/D %.4f %.4f %.4f m, worst horizontal %.3f m, n %lld", which,
       state, rms.x(), rms.y(), rms.z(), sum.worst_horizontal_m, Count(sum.count));
}

void Score(std::string& out, const char* which, const ScoreSummary& score) {
  HeldOut(out, which, "fixed", score.held_out_fixed);
  HeldOut(out, which, "float", score.held_out_float);
  if (score.held_out_uncovered > 0) {
    Line(out, "held out, %s: %lld epochs without a solution", which,
         Count(score.held_out_uncovered));
  }
  if (score.windows.empty()) return;
  for (const WindowError& w : score.windows) {
    const std::string begin = FormatSeconds(w.window.begin);
    const std::string end = FormatSeconds(w.window.end);
    if (w.count == 0) {
      Line(out, "blanked %s to %s, %s: no fixed position to compare with", begin.c_str(),
           end.c_str(), which);
    } else {
      Line(out, "blanked %s to %s, %s: largest horizontal error %.3f m, n %lld", begin.c_str(),
           end.c_str(), which, w.worst_horizontal_m, Count(w.count));
    }
  }
  Line(out, "blanked, %s: RMS of the largest errors %.3f m, %zu windows", which,
       RmsOfWorst(score.windows), score.windows.size());
}

}  // namespace

std::string SummaryTable(const RunSummary& summary) {
  std::string out;
  SourceTable(out, summary.stats);
  Events(out, summary.stats);
  Calibration(out, summary);
  if (summary.scored) {
    Score(out, "real time", summary.real_time);
    if (summary.smoothed) Score(out, "smoothed", *summary.smoothed);
  }
  if (summary.bad_rows > 0) {
    Line(out, "input rows left out: %lld (see above)", Count(summary.bad_rows));
  }
  if (summary.seconds_to_first_row) {
    Line(out, "%lld rows; solution from %.1f s after the first IMU sample", Count(summary.rows),
         *summary.seconds_to_first_row);
  } else {
    Line(out, "no solution: no position came, or the heading stayed unknown (did it move?)");
  }
  const double samples = static_cast<double>(summary.stats.imu_samples);
  Line(out, "%.1f s of data in %.2f s; filter %.2f us an IMU sample%s", summary.imu_span_s,
       summary.total_s, samples > 0.0 ? 1e6 * summary.filter_s / samples : 0.0,
       summary.smoothed ? "" : ".");
  if (summary.smoothed) {
    out.pop_back();
    Line(out, ", smoother %.2f s.", summary.smoother_s);
  }
  return out;
}

}  // namespace kawara::navigate
