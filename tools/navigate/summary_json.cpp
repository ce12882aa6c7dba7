// The same as the table, for programs.
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "tools/navigate/decimal_time.hpp"
#include "tools/navigate/run_summary.hpp"

namespace kawara::navigate {
namespace {

/// Writes "key": value pairs of nested objects with the commas where they belong.
class Json {
 public:
  void Open(std::string_view key, char bracket = '{') {
    Key(key);
    out_ += bracket;
    first_ = true;
  }
  void Close(char bracket = '}') {
    out_ += bracket;
    first_ = false;
  }
  void Number(std::string_view key, double value) {
    Key(key);
    if (!std::isfinite(value)) {
      out_ += "null";
      return;
    }
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.9g", value);
    out_ += text.data();
  }
  void Integer(std::string_view key, std::int64_t value) {
    Key(key);
    out_ += std::to_string(value);
  }
  /// Text that needs no escapes.
  void Literal(std::string_view key, std::string_view value) {
    Key(key);
    out_ += value;
  }
  void Pair(std::string_view key, const Found& found) {
    Open(key);
    Number("value", found.value);
    Number("sd", found.sd);
    Close();
  }
  const std::string& text() const { return out_; }

 private:
  void Key(std::string_view key) {
    if (!first_) out_ += ", ";
    first_ = false;
    if (!key.empty()) out_.append("\"").append(key).append("\": ");
  }
  std::string out_;
  bool first_ = true;
};

void Sources(Json& json, const estimation::NavigationStats& stats) {
  json.Open("sources");
  for (int i = 0; i < estimation::kNavSources; ++i) {
    const estimation::SourceStats& s = stats.source[static_cast<std::size_t>(i)];
    json.Open(ToString(static_cast<estimation::NavSource>(i)));
    json.Integer("offered", s.offered);
    json.Integer("accepted", s.accepted);
    json.Integer("rejected", s.rejected);
    json.Number("nis_per_dof",
                s.nis_dof > 0 ? s.nis_sum / static_cast<double>(s.nis_dof) : std::nan(""));
    json.Close();
  }
  json.Close();
}

void Counts(Json& json, const estimation::NavigationStats& s) {
  json.Integer("imu_samples", s.imu_samples);
  json.Integer("imu_duplicates", s.imu_duplicates);
  json.Integer("imu_backwards", s.imu_backwards);
  json.Integer("imu_invalid", s.imu_invalid);
  json.Integer("imu_spikes", s.imu_spikes);
  json.Integer("imu_gaps", s.imu_gaps);
  json.Integer("late_fused", s.late_fused);
  json.Integer("too_late", s.too_late);
  json.Integer("invalid", s.invalid);
  json.Integer("repeated", s.repeated);
  json.Integer("outages", s.outages);
  json.Number("longest_outage_s", s.longest_outage_s);
  json.Integer("wrong_fix_episodes", s.wrong_fix_episodes);
  json.Integer("resets", s.resets);
  json.Integer("alignments", s.alignments);
}

void Calibration(Json& json, const CalibrationFound& c) {
  json.Open("found");
  json.Pair("time_offset_s", c.time_offset_s);
  json.Pair("speed_scale", c.speed_scale);
  json.Pair("turn_scale", c.turn_scale);
  json.Pair("mount_pitch_deg", c.mount_pitch_deg);
  json.Pair("mount_yaw_deg", c.mount_yaw_deg);
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    json.Pair(std::string("gyro_bias_degps_") + kAxes[i], c.gyro_bias_degps[i]);
    json.Pair(std::string("accel_bias_mps2_") + kAxes[i], c.accel_bias_mps2[i]);
  }
  json.Close();
}

void HeldOut(Json& json, std::string_view key, const ErrorSum& sum) {
  json.Open(key);
  json.Integer("n", sum.count);
  const Eigen::Vector3d rms = sum.RmsNed();
  json.Number("rms_n_m", rms.x());
  json.Number("rms_e_m", rms.y());
  json.Number("rms_d_m", rms.z());
  json.Number("worst_horizontal_m", sum.count > 0 ? sum.worst_horizontal_m : std::nan(""));
  json.Close();
}

void Score(Json& json, std::string_view key, const ScoreSummary& score) {
  json.Open(key);
  HeldOut(json, "held_out_fixed", score.held_out_fixed);
  HeldOut(json, "held_out_float", score.held_out_float);
  json.Integer("held_out_uncovered", score.held_out_uncovered);
  json.Number("rms_of_worst_m", RmsOfWorst(score.windows));
  json.Open("windows", '[');
  for (const WindowError& w : score.windows) {
    json.Open("");
    json.Literal("t_start", FormatSeconds(w.window.begin));
    json.Literal("t_end", FormatSeconds(w.window.end));
    json.Integer("n", w.count);
    json.Number("worst_horizontal_m", w.count > 0 ? w.worst_horizontal_m : std::nan(""));
    json.Close();
  }
  json.Close(']');
  json.Close();
}

}  // namespace

std::string SummaryJson(const RunSummary& summary) {
  Json json;
  json.Open("");
  Sources(json, summary.stats);
  Counts(json, summary.stats);
  if (summary.found) {
    Calibration(json, *summary.found);
  } else {
    json.Literal("found", "null");
  }
  if (summary.scored) {
    Score(json, "real_time", summary.real_time);
    if (summary.smoothed) Score(json, "smoothed", *summary.smoothed);
  }
  json.Integer("rows", summary.rows);
  json.Integer("input_rows_left_out", summary.bad_rows);
  json.Number("seconds_to_first_row", summary.seconds_to_first_row.value_or(std::nan("")));
  json.Number("data_s", summary.imu_span_s);
  json.Number("filter_s", summary.filter_s);
  json.Number("smoother_s", summary.smoother_s);
  json.Number("total_s", summary.total_s);
  json.Close();
  return json.text() + "\n";
}

}  // namespace kawara::navigate
