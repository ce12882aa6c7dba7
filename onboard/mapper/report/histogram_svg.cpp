#include "onboard/mapper/report/histogram_svg.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "core/html.hpp"

namespace kawara::mapper {
namespace {

constexpr int kBars = 40;
// Of the drawing, in its own units.
constexpr double kWidth = 400, kHeight = 200, kLeft = 42, kRight = 18, kTop = 26, kBottom = 34;
constexpr double kInnerWidth = kWidth - kLeft - kRight, kInnerHeight = kHeight - kTop - kBottom;

/// With two digits behind the point at most and no zeros that say nothing.
std::string Short(double value) {
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), std::round(value * 100.0) / 100.0);
  return {text.data(), end};
}

/// ` x="12.5"`
std::string With(const char* name, double value) {
  return std::string(" ") + name + "=\"" + Short(value) + "\"";
}

std::string Text(const char* kind, double x, double y, const std::string& text) {
  return std::string("<text class=\"") + kind + "\"" + With("x", x) + With("y", y) + ">" +
         core::HtmlEscaped(text) + "</text>";
}

std::string GridLine(double x1, double y1, double x2, double y2) {
  return "<line class=\"grid\"" + With("x1", x1) + With("y1", y1) + With("x2", x2) +
         With("y2", y2) + "/>";
}

/// 1, 2 or 5 times a power of ten, not below `value`.
double RoundUp(double value) {
  const double ten = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * ten >= value * (1.0 - 1e-9)) return step * ten;
  }
  return 10.0 * ten;
}

std::string Axes(double most_percent, int reach_mm) {
  std::string svg;
  for (const double part : {0.0, 0.5, 1.0}) {
    const double y = kTop + kInnerHeight * (1.0 - part);
    svg += GridLine(kLeft, y, kWidth - kRight, y);
    svg += Text("end", kLeft - 4, y + 4, Short(part * most_percent) + " %");
  }
  for (const double part : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const double x = kLeft + kInnerWidth * 0.5 * (1.0 + part);
    svg += GridLine(x, kTop, x, kTop + kInnerHeight + 4);
    svg += Text("mid", x, kTop + kInnerHeight + 16, Short(part * reach_mm));
  }
  return svg + Text("mid", kLeft + 0.5 * kInnerWidth, kHeight - 4, "error [mm]");
}

}  // namespace

int HistogramReachMm(const ErrorHistogram& errors) {
  constexpr double kShown = 0.95;
  constexpr int kLeastMm = 20;  // a bar a millimetre
  const int wanted = std::max(kLeastMm, errors.SizeOfShareMm(kShown));
  for (const int reach : {20, 40, 60, 80, 100, 200, 400, 600, 800, 1000, 2000}) {
    if (reach >= wanted) return reach;
  }
  return ErrorHistogram::kLimitMm;
}

std::string HistogramSvg(const ErrorHistogram& errors, int reach_mm, const std::string& title) {
  const auto total = static_cast<double>(std::max<std::uint64_t>(errors.total(), 1));
  std::vector<double> percent;
  double inside = 0.0, most = 0.0;
  for (int i = 0; i < kBars; ++i) {
    const auto edge = [reach_mm](int k) { return 2 * reach_mm * k / kBars - reach_mm; };
    percent.push_back(100.0 * static_cast<double>(errors.Count(edge(i), edge(i + 1))) / total);
    inside += percent.back();
    most = std::max(most, percent.back());
  }
  const double scale = RoundUp(std::max(most, 0.1));

  const double beyond = errors.total() > 0 ? std::max(0.0, 100.0 - inside) : 0.0;
  std::string svg = "<svg class=\"hist\" viewBox=\"0 0 " + Short(kWidth) + " " + Short(kHeight) +
                    "\" role=\"img\"><title>" + core::HtmlEscaped(title) + "</title>" +
                    Text("head", kLeft, 14, title) +
                    Text("end", kWidth - kRight, 14, "beyond: " + Short(beyond) + " %") +
                    Axes(scale, reach_mm);
  constexpr double kStep = kInnerWidth / kBars;
  for (int i = 0; i < kBars; ++i) {
    const double height = kInnerHeight * percent[static_cast<std::size_t>(i)] / scale;
    if (height <= 0.0) continue;
    svg += "<rect" + With("x", kLeft + i * kStep + 0.5) + With("y", kTop + kInnerHeight - height) +
           With("width", kStep - 1.0) + With("height", height) + "/>";
  }
  return svg + "</svg>\n";
}

}  // namespace kawara::mapper
