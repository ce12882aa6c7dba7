#include "sim/evaluate/error_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace kawara::sim {
namespace {

/// Right-aligned in 10 columns.
std::string Cell(double value) {
  char text[48];
  std::snprintf(text, sizeof(text), " %9.4f", value);
  return text;
}

std::string SingleCell(double value) {
  char text[48];
  std::snprintf(text, sizeof(text), " %9.6g", value);
  return text;
}

std::string JsonNumber(double value) {
  if (!std::isfinite(value)) return "null";
  char text[48];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

}  // namespace

ErrorStatistics Summarise(const std::vector<double>& errors) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (errors.empty()) return {0, kNan, kNan, kNan, kNan, kNan, kNan};
  ErrorStatistics s;
  s.count = errors.size();
  const auto n = static_cast<double>(errors.size());
  double sum = 0.0, squares = 0.0;
  for (const double e : errors) sum += e;
  s.mean = sum / n;
  double about_mean = 0.0;
  for (const double e : errors) {
    squares += e * e;
    about_mean += (e - s.mean) * (e - s.mean);
  }
  s.rms = std::sqrt(squares / n);
  s.sd = std::sqrt(about_mean / n);
  std::vector<double> sizes(errors.size());
  std::transform(errors.begin(), errors.end(), sizes.begin(), [](double e) { return std::abs(e); });
  std::sort(sizes.begin(), sizes.end());
  s.median = sizes.size() % 2 == 1 ? sizes[sizes.size() / 2]
                                   : 0.5 * (sizes[sizes.size() / 2 - 1] + sizes[sizes.size() / 2]);
  s.p95 = sizes[static_cast<std::size_t>(std::ceil(0.95 * n)) - 1];
  s.max = sizes.back();
  return s;
}

void ErrorReport::Add(std::string name, std::string unit, const ErrorStatistics& statistics) {
  rows_.push_back({std::move(name), std::move(unit), statistics, false, 0.0});
}

void ErrorReport::Add(std::string name, std::string unit, double value) {
  rows_.push_back({std::move(name), std::move(unit), {}, true, value});
}

std::string ErrorReport::Text() const {
  std::size_t width = 4;
  for (const Row& row : rows_) width = std::max(width, row.name.size());
  const auto padded = [width](const std::string& name) {
    return name + std::string(width - name.size(), ' ');
  };
  const bool any_statistics =
      std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return !row.is_single; });
  std::string text;
  if (any_statistics) {
    text = padded("") + "         n      mean        sd       rms    median      95 %       max\n";
  }
  for (const Row& row : rows_) {
    text += padded(row.name);
    if (row.is_single) {
      text += SingleCell(row.value);
    } else {
      const ErrorStatistics& s = row.statistics;
      text += SingleCell(static_cast<double>(s.count));
      for (const double value : {s.mean, s.sd, s.rms, s.median, s.p95, s.max}) {
        text += Cell(value);
      }
    }
    text += " " + row.unit + "\n";
  }
  return text;
}

std::string ErrorReport::Json() const {
  std::string json = "{";
  for (const Row& row : rows_) {
    if (json.size() > 1) json += ", ";
    json += "\"" + row.name + "\": {\"unit\": \"" + row.unit + "\", ";
    if (row.is_single) {
      json += "\"value\": " + JsonNumber(row.value) + "}";
      continue;
    }
    const ErrorStatistics& s = row.statistics;
    json += "\"n\": " + std::to_string(s.count) + ", \"mean\": " + JsonNumber(s.mean) +
            ", \"sd\": " + JsonNumber(s.sd) + ", \"rms\": " + JsonNumber(s.rms) +
            ", \"median\": " + JsonNumber(s.median) + ", \"p95\": " + JsonNumber(s.p95) +
            ", \"max\": " + JsonNumber(s.max) + "}";
  }
  return json + "}";
}

}  // namespace kawara::sim
