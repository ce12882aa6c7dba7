#include "tools/calibrate/residual_plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geodesy.hpp"
#include "tools/calibrate/printed.hpp"

namespace kawara::calibrate {
namespace {

constexpr double kWidth = 480.0, kHeight = 240.0, kMargin = 44.0;

/// A power of ten, twice or five times one, not below `least`.
double RoundUp(double least) {
  const double ten = std::pow(10.0, std::floor(std::log10(std::max(1e-9, least))));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * ten >= least) return step * ten;
  }
  return 10.0 * ten;
}

/// That 99 of a hundred stay below.
double Reach(const std::vector<Residual>& residuals) {
  std::vector<double> sizes;
  for (const Residual& r : residuals) {
    if (r.used) sizes.push_back(r.miss_px.norm());
  }
  if (sizes.empty()) return 1.0;
  const auto most = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 99 / 100);
  std::ranges::nth_element(sizes, most);
  return RoundUp(*most);
}

std::string Open(double width, double height, const char* label) {
  return Printed("<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"%s\">", width, height,
                 label);
}

std::string Axes(double reach_x, const char* name_x, double reach_y, const char* name_y) {
  return Printed("<path class=\"axis\" d=\"M%.0f %.0fV%.0fH%.0f\"/>", kMargin, kMargin / 2,
                 kHeight - kMargin, kWidth - kMargin / 2) +
         Printed("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"end\">%g %s</text>",
                 kWidth - kMargin / 2, kHeight - kMargin / 2, reach_x, name_x) +
         Printed("<text x=\"4\" y=\"%.0f\">%g %s</text>", kMargin / 2 - 6, reach_y, name_y);
}

/// A cell's outline: a part of a ring.
std::string CellPath(const Eigen::Vector2d& center, double inner, double outer, double from,
                     double to) {
  const auto at = [&](double r, double a) {
    return Printed("%.1f %.1f", center.x() + r * std::cos(a), center.y() + r * std::sin(a));
  };
  return "M" + at(inner, from) + "L" + at(outer, from) +
         Printed("A%.1f %.1f 0 0 1 ", outer, outer) + at(outer, to) + "L" + at(inner, to) +
         Printed("A%.1f %.1f 0 0 0 ", inner, inner) + at(inner, from) + "Z";
}

}  // namespace

std::string ResidualArrowsSvg(const std::vector<Residual>& residuals, int width_px, int height_px,
                              const Eigen::Vector2d& center_px, const vision::Coverage& coverage) {
  using vision::Coverage;
  const double reach = Reach(residuals), side = std::min(width_px, height_px);
  const double scale = 0.05 * side / reach, stroke = side / 500.0;
  std::string svg = Open(width_px, height_px, "residuals over the picture");
  svg += Printed("<rect class=\"frame\" width=\"%d\" height=\"%d\"/>", width_px, height_px);
  for (int ring = 0; ring < Coverage::kRings; ++ring) {
    const double inner = coverage.rim_px * ring / Coverage::kRings;
    const double outer = coverage.rim_px * (ring + 1) / Coverage::kRings;
    if (outer < coverage.low_px) continue;  // the hole of a ring
    for (int sector = 0; sector < Coverage::kSectors; ++sector) {
      if (coverage.corners[static_cast<std::size_t>(ring)][static_cast<std::size_t>(sector)] > 0) {
        continue;
      }
      const double turn = 2.0 * core::kPi / Coverage::kSectors;
      svg += "<path class=\"empty\" d=\"" +
             CellPath(center_px, inner, outer, sector * turn - core::kPi,
                      (sector + 1) * turn - core::kPi) +
             "\"/>";
    }
  }
  for (const Residual& r : residuals) {
    const Eigen::Vector2d end = r.pixel_px + scale * r.miss_px;
    svg +=
        Printed("<path class=\"%s\" stroke-width=\"%.2f\" d=\"M%.1f %.1fL%.1f %.1f\"/>",
                r.used ? "arrow" : "out", stroke, r.pixel_px.x(), r.pixel_px.y(), end.x(), end.y());
  }
  svg += Printed("<path class=\"out\" stroke-width=\"%.2f\" d=\"M%.1f %.1fh%.1f\"/>", 2 * stroke,
                 0.03 * side, 0.97 * side, scale * reach);
  svg += Printed("<text font-size=\"%.0f\" x=\"%.1f\" y=\"%.1f\">%g px</text>", 0.03 * side,
                 0.03 * side, 0.96 * side, reach);
  return svg + "</svg>";
}

std::string ResidualHistogramSvg(const std::vector<Residual>& residuals) {
  constexpr int kBars = 40;
  const double reach = Reach(residuals);
  std::array<int, kBars> bars{};
  for (const Residual& r : residuals) {
    if (!r.used) continue;
    for (const double miss : {r.miss_px.x(), r.miss_px.y()}) {
      const auto bar = static_cast<int>(std::floor((miss / reach + 1.0) * kBars / 2));
      if (bar >= 0 && bar < kBars) ++bars[static_cast<std::size_t>(bar)];
    }
  }
  const int most = std::max(1, *std::ranges::max_element(bars));
  std::string svg = Open(kWidth, kHeight, "histogram of residuals");
  svg += Axes(reach, "px", most, "coordinates");
  svg +=
      Printed("<text x=\"%.0f\" y=\"%.0f\">%g px</text>", kMargin, kHeight - kMargin / 2, -reach);
  const double step = (kWidth - 1.5 * kMargin) / kBars;
  for (int i = 0; i < kBars; ++i) {
    const double height = (kHeight - 1.5 * kMargin) * bars[static_cast<std::size_t>(i)] / most;
    svg += Printed("<rect class=\"bar\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>",
                   kMargin + i * step, kHeight - kMargin - height, step - 1, height);
  }
  return svg + "</svg>";
}

std::string ResidualRadiusSvg(const std::vector<Residual>& residuals,
                              const Eigen::Vector2d& center_px) {
  constexpr std::size_t kRings = 12;
  const double reach = Reach(residuals);
  double far = 1.0;
  for (const Residual& r : residuals) far = std::max(far, (r.pixel_px - center_px).norm());
  const double high = kHeight - 1.5 * kMargin, wide = kWidth - 1.5 * kMargin;
  std::array<double, kRings> squares{};
  std::array<int, kRings> counts{};
  std::string svg = Open(kWidth, kHeight, "residuals over the radius");
  svg += Axes(std::round(far), "px from the centre", reach, "px");
  for (const Residual& r : residuals) {
    if (!r.used) continue;
    const double share = (r.pixel_px - center_px).norm() / far;
    const double size = std::min(1.0, r.miss_px.norm() / reach);
    svg += Printed("<circle class=\"dot\" cx=\"%.1f\" cy=\"%.1f\" r=\"1.2\"/>",
                   kMargin + wide * share, kHeight - kMargin - high * size);
    const auto ring = std::min(kRings - 1, static_cast<std::size_t>(share * kRings));
    squares[ring] += r.miss_px.squaredNorm();
    ++counts[ring];
  }
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    if (counts[ring] == 0) continue;
    const double rms = std::min(1.0, std::sqrt(squares[ring] / counts[ring]) / reach);
    svg += Printed("<path class=\"rms\" d=\"M%.1f %.1fh%.1f\"/>",
                   kMargin + wide * static_cast<double>(ring) / kRings,
                   kHeight - kMargin - high * rms, wide / kRings);
  }
  return svg + "</svg>";
}

}  // namespace kawara::calibrate
