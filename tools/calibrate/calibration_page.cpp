#include "tools/calibrate/calibration_page.hpp"

#include <cmath>

#include "core/html.hpp"
#include "tools/calibrate/printed.hpp"
#include "tools/calibrate/residual_plots.hpp"

namespace kawara::calibrate {
namespace {

using core::HtmlEscaped;

constexpr const char* kStyle =
    R"(body{font:15px/1.45 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}
table{border-collapse:collapse}td,th{padding:.15em .8em;text-align:right;border-bottom:1px solid #ddd}
th:first-child{text-align:left}svg{max-width:100%;height:auto;font:11px sans-serif}figure{margin:1em 0}
.frame{fill:#fff;stroke:#999}.empty{fill:#f3d9b1}.arrow,.axis{fill:none;stroke:#235}.out{stroke:#c22}
.bar{fill:#579}.dot{fill:#579;opacity:.5}.rms{stroke:#c22;stroke-width:2}.warn{color:#a40})";

std::string Figure(const std::string& svg, const char* caption) {
  return "<figure>" + svg + "<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string PicturesTable(const vision::CameraCalibration& made, const BoardPictures& pictures) {
  std::string page =
      "<h2>Pictures</h2>\n<table><tr><th>picture</th><th>corners</th><th>left out</th>"
      "<th>rms px</th></tr>\n";
  for (std::size_t v = 0; v < pictures.views.size(); ++v) {
    double sum = 0.0;
    int used = 0;
    const int all = static_cast<int>(pictures.views[v].size());
    for (std::size_t c = 0; c < pictures.views[v].size(); ++c) {
      if (!made.fit.used[v][c]) continue;
      sum += made.fit.residuals[v][c].squaredNorm();
      ++used;
    }
    page += "<tr><th>" + HtmlEscaped(pictures.names[v]) +
            Printed("</th><td>%d</td><td>%d</td><td>%.3f</td></tr>\n", all, all - used,
                    used > 0 ? std::sqrt(sum / used) : 0.0);
  }
  return page + "</table>\n";
}

}  // namespace

std::string CalibrationPage(const vision::CameraCalibration& made, const BoardPictures& pictures,
                            const std::string& origin) {
  std::vector<Residual> residuals;
  for (std::size_t v = 0; v < pictures.views.size(); ++v) {
    for (std::size_t c = 0; c < pictures.views[v].size(); ++c) {
      residuals.push_back(
          {pictures.views[v][c].pixel_px, made.fit.residuals[v][c], made.fit.used[v][c]});
    }
  }
  const Eigen::Vector2d center_px = made.fit.state.parameters.head<2>();
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Camera "
      "calibration</title><style>" +
      std::string(kStyle) +
      "</style></head><body>\n<h1>Camera calibration: " + HtmlEscaped(NameOf(made.model)) +
      "</h1>\n<p>From " + HtmlEscaped(origin) + ".</p>\n";
  for (const std::string& warning : made.warnings) {
    page += "<p class=\"warn\">Warning: " + HtmlEscaped(warning) + "</p>\n";
  }
  page += Printed(
      "<p>Residuals %.3f px rms; of pictures it was not fitted to %.3f px rms; directions are "
      "projected to %.3f px (1 sigma) at the worst; %zu corners, %d left out. Boards cover %.0f %% "
      "of the picture's cells, %.0f %% of its radius.</p>\n",
      made.fit.rms_px, made.cross_validated_px, made.projection_sd_px, residuals.size(),
      made.left_out, 100.0 * made.coverage.CellShare(), 100.0 * made.coverage.RadiusShare());
  page += "<table><tr><th>number</th><th>value</th><th>1 sigma</th></tr>\n";
  for (const vision::EstimatedNumber& number : made.numbers) {
    page += "<tr><th>" + HtmlEscaped(number.name) +
            Printed("</th><td>%.8g</td><td>%.2g</td></tr>\n", number.value, number.sd);
  }
  page += "</table>\n<h2>Residuals</h2>\n";
  page += Figure(
      ResidualArrowsSvg(residuals, pictures.width_px, pictures.height_px, center_px, made.coverage),
      "Seen less computed, drawn out; red: left out. Shaded: cells no board was in.");
  page += Figure(ResidualHistogramSvg(residuals), "Both coordinates of all corners used.");
  page += Figure(ResidualRadiusSvg(residuals, center_px),
                 "Size over the distance from the centre; red: root mean square of a ring.");
  return page + PicturesTable(made, pictures) + "</body></html>\n";
}

}  // namespace kawara::calibrate
