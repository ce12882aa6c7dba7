#include "tools/navigate/report_page.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <functional>

#include "core/html.hpp"
#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

/// With so many digits behind the point and no zeros that say nothing; null if it is no number.
void AppendNumber(std::string& out, double value, int digits) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  const double scale = std::pow(10.0, digits);
  // Rounded first, so that the shortest text that reads back the same is short.
  const double rounded = std::round(value * scale) / scale + 0.0;
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), rounded);
  out.append(text.data(), end);
}

/// "name":[...] of one number of every item.
template <class Items, class Number>
void AppendArray(std::string& out, const char* name, const Items& items, int digits,
                 Number number) {
  out.append("\"").append(name).append("\":[");
  bool first = true;
  for (const auto& item : items) {
    if (!first) out += ',';
    first = false;
    AppendNumber(out, std::invoke(number, item), digits);
  }
  out += "],\n";
}

void AppendTrack(std::string& out, const PlotData& plot, double t0) {
  const auto& points = plot.points();
  std::vector<Eigen::Vector3d> ned;
  ned.reserve(points.size());
  for (const TrajectoryPoint& p : points) {
    ned.push_back(core::NedBetween(plot.origin(), p.position));
  }
  AppendArray(out, "n", ned, 3, [](const auto& p) { return p.x(); });
  AppendArray(out, "e", ned, 3, [](const auto& p) { return p.y(); });
  using Point = TrajectoryPoint;
  const auto add = [&](const char* name, int digits, auto number) {
    AppendArray(out, name, points, digits, number);
  };
  add("t", 2, [t0](const Point& p) { return SecondsOf(p.time) - t0; });
  add("h", 3, [](const Point& p) { return p.position.h_ellipsoidal_m; });
  constexpr std::array<const char*, 3> kVelocity{"vn", "ve", "vd"};
  constexpr std::array<const char*, 3> kPositionSd{"sn", "se", "sd"};
  constexpr std::array<const char*, 3> kAttitudeSd{"sr", "sp", "sy"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    add(kVelocity[i], 3, [axis](const Point& p) { return p.velocity_ned_mps[axis]; });
    add(kPositionSd[i], 4, [axis](const Point& p) { return p.position_sd_ned_m[axis]; });
    add(kAttitudeSd[i], 4,
        [axis](const Point& p) { return p.attitude_sd_rad[axis] * core::kDegFromRad; });
  }
  add("roll", 3, [](const Point& p) { return p.attitude.roll_rad * core::kDegFromRad; });
  add("pitch", 3, [](const Point& p) { return p.attitude.pitch_rad * core::kDegFromRad; });
  add("yaw", 2, [](const Point& p) {
    const double deg = p.attitude.yaw_rad * core::kDegFromRad;
    return deg < 0.0 ? deg + 360.0 : deg;
  });
  add("st", 0, [](const Point& p) { return static_cast<double>(p.state); });
}

void AppendFixes(std::string& out, const PlotData& plot, double t0) {
  const auto& fixes = plot.fixes();
  AppendArray(out, "ft", fixes, 3, [t0](const auto& f) { return SecondsOf(f.time) - t0; });
  AppendArray(out, "fn", fixes, 3, [](const auto& f) { return f.ned_m.x(); });
  AppendArray(out, "fe", fixes, 3, [](const auto& f) { return f.ned_m.y(); });
  AppendArray(out, "fq", fixes, 0, [](const auto& f) { return static_cast<double>(f.rtk); });
  AppendArray(out, "fr", fixes, 0, [](const auto& f) { return static_cast<double>(f.role); });
  constexpr std::array<const char*, 3> kResidual{"rn", "re", "rd"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    AppendArray(out, kResidual[i], fixes, 3, [axis](const PlottedFix& f) {
      return f.residual_ned_m ? (*f.residual_ned_m)[axis] : std::nan("");
    });
  }
}

void AppendSpans(std::string& out, const PlotData& plot, const std::vector<TimeWindow>& blanks,
                 double t0) {
  const auto begin_end = [&](core::GpsTime begin, core::GpsTime end) {
    out += '[';
    AppendNumber(out, SecondsOf(begin) - t0, 2);
    out += ',';
    AppendNumber(out, SecondsOf(end) - t0, 2);
  };
  out += "\"spans\":[";
  for (const StateSpan& span : plot.states()) {
    if (&span != &plot.states().front()) out += ',';
    begin_end(span.begin, span.end);
    out.append(",").append(std::to_string(static_cast<int>(span.state)));
    out.append(",\"").append(ToString(span.reason)).append("\"]");
  }
  out += "],\n\"blanks\":[";
  for (const TimeWindow& window : blanks) {
    if (&window != &blanks.front()) out += ',';
    begin_end(window.begin, window.end);
    out += ']';
  }
  out += "],\n\"states\":[";
  for (int i = 0; i <= static_cast<int>(estimation::NavState::kFixed); ++i) {
    if (i > 0) out += ',';
    out.append("\"").append(ToString(static_cast<estimation::NavState>(i))).append("\"");
  }
  out += "]";
}

}  // namespace

std::string ReportPage(const PlotData& plot, const std::vector<TimeWindow>& blanks,
                       const std::string& title, const std::string& summary) {
  const double t0 = plot.empty() ? 0.0 : std::floor(SecondsOf(plot.points().front().time));
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      core::HtmlEscaped(title) + "</title>\n<style>" + kReportStyle +
      "</style></head><body>\n<h1>" + core::HtmlEscaped(title) +
      "</h1>\n<div id=\"legend\"></div>\n<div id=\"page\"><div><div "
      "id=\"plan\"></div><h2>Summary</h2>\n<pre>" +
      core::HtmlEscaped(summary) +
      "</pre></div><div id=\"panels\"></div></div>\n<script>\n\"use strict\";\nconst D = "
      "{\n\"t0\":";
  AppendNumber(page, t0, 0);
  page += ",\n";
  AppendTrack(page, plot, t0);
  AppendFixes(page, plot, t0);
  AppendSpans(page, plot, blanks, t0);
  page += "};\n";
  page += kReportScript;
  page += "</script></body></html>\n";
  return page;
}

}  // namespace kawara::navigate
