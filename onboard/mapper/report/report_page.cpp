#include "onboard/mapper/report/report_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "core/base64.hpp"
#include "core/html.hpp"
#include "core/iso8601.hpp"
#include "onboard/mapper/report/histogram_svg.hpp"
#include "onboard/mapper/report/range_colours.hpp"

namespace kawara::mapper {
namespace {

using core::HtmlEscaped;

std::string Number(double value, int digits) {
  if (!std::isfinite(value)) return "\u2013";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

/// A path in a link: percent-encoded and below the page's folder, so that no name can become an
/// address of its own ("javascript:", "//host"). Source: RFC 3986, 2.1 and 4.2.
std::string RelativeUrl(std::string_view path) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string url = "./";
  for (const char c : path.substr(std::min(path.find_first_not_of('/'), path.size()))) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '.' || c == '_' || c == '~' || c == '/';
    if (plain) {
      url += c;
      continue;
    }
    const auto code = static_cast<unsigned char>(c);
    url.append("%").append(1, kHex[code >> 4]).append(1, kHex[code & 15U]);
  }
  return url;
}

/// A round length that takes about a fifth of the picture's width.
double BarLengthM(double width_m) {
  const double wanted = 0.2 * width_m;
  const double ten = std::pow(10.0, std::floor(std::log10(wanted)));
  double length = ten;
  for (const double step : {2.0, 5.0}) {
    if (step * ten <= wanted) length = step * ten;
  }
  return length;
}

void AppendPicture(std::string& page, const ReportPicture& picture) {
  if (picture.bytes.empty()) return;
  const std::string size = R"(" width=")" + std::to_string(picture.width_px) + R"(" height=")" +
                           std::to_string(picture.height_px);
  page +=
      R"(<figure><img src="data:)" + picture.mime + ";base64," +
      core::Base64({reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size()}) +
      size + R"(" alt=")" + HtmlEscaped(picture.caption) + R"(">)";
  std::string bar;
  if (picture.px_per_m > 0.0) {
    const double width_m = picture.width_px / picture.px_per_m;
    const double bar_m = BarLengthM(width_m);
    page +=
        R"(<div class="bar" style="width:)" + Number(100.0 * bar_m / width_m, 2) + R"(%"></div>)";
    bar = Number(bar_m, bar_m < 1.0 ? 2 : 0) + " m. ";
  }
  page += "<figcaption>" + bar + HtmlEscaped(picture.caption) + "</figcaption></figure>\n";
}

void AppendRows(std::string& page, const char* heading, const std::vector<ReportRow>& rows) {
  if (rows.empty()) return;
  page.append("<div><h2>").append(heading).append("</h2>\n<table><tbody>\n");
  for (const ReportRow& row : rows) {
    page += "<tr><th scope=\"row\">" + HtmlEscaped(row.name) + "</th><td>" +
            HtmlEscaped(row.value) + (row.unit.empty() ? "" : " " + HtmlEscaped(row.unit)) +
            "</td></tr>\n";
  }
  page += "</tbody></table></div>\n";
}

struct BandRow {
  const char* name;
  std::size_t first, last;  ///< of Accuracy's bands
};
constexpr std::array<BandRow, 5> kBandRows{{{"2\u20136 m", 1, 2},
                                            {"2\u20134 m", 1, 1},
                                            {"4\u20136 m", 2, 2},
                                            {"6\u20138 m", 3, 3},
                                            {"all ranges", 0, Accuracy::kBands - 1}}};

void AppendAccuracyTable(std::string& page, const Accuracy& accuracy) {
  page +=
      "<div class=\"wide\"><table class=\"num\"><thead><tr><th scope=\"col\">true range</th>"
      "<th scope=\"col\">std</th><th scope=\"col\">NMAD</th><th scope=\"col\">bias</th>"
      "<th scope=\"col\">outliers</th><th scope=\"col\">density</th>"
      "<th scope=\"col\">&lt; 2 sd</th><th scope=\"col\">pixels</th></tr></thead><tbody>\n";
  for (const BandRow& row : kBandRows) {
    const AccuracyFigures f = accuracy.Figures(row.first, row.last);
    const auto cell = [&page](double value, int digits, const char* unit) {
      page += "<td>" + Number(value, digits) + (std::isfinite(value) ? unit : "") + "</td>";
    };
    page += std::string("<tr><th scope=\"row\">") + row.name + "</th>";
    cell(1e3 * f.std_m, 1, " mm");
    cell(1e3 * f.nmad_m, 1, " mm");
    cell(1e3 * f.bias_m, 1, " mm");
    cell(100.0 * f.outliers, 2, " %");
    cell(100.0 * f.density, 1, " %");
    cell(100.0 * f.within_2_sd, 1, " %");
    page += "<td>" + std::to_string(f.known) + "</td></tr>\n";
  }
  page += "</tbody></table></div>\n";
}

void AppendAccuracy(std::string& page, const MapperReport& report) {
  if (!report.accuracy) return;
  const Accuracy& accuracy = *report.accuracy;
  page += "<h2>Accuracy</h2>\n<p>" + std::to_string(accuracy.images()) +
          (accuracy.images() == 1 ? " distance image. " : " distance images. ") +
          HtmlEscaped(report.accuracy_against) + "</p>\n";
  AppendAccuracyTable(page, accuracy);
  page += "<div class=\"hists\">\n";
  for (const BandRow& row : kBandRows) {
    const ErrorHistogram errors = accuracy.Errors(row.first, row.last);
    if (errors.total() == 0) continue;
    page += HistogramSvg(errors, HistogramReachMm(errors), row.name);
  }
  page +=
      "</div>\n<p class=\"note\">An error is the measured range less the true one, along the "
      "pixel's ray. std and bias: of the errors within 10 % of the true range. NMAD: 1.4826 times "
      "the median size of all errors, bias included. Outliers: share of the measured pixels with "
      "an error over 10 %. Density: share of the judged pixels that were measured. &lt; 2 sd: "
      "share of the measured pixels whose error is below twice the deviation stated for them "
      "(95 % of honest ones). The histograms are those of the paper's Fig. 18, which found a "
      "standard deviation of 151 mm at 2\u20136 m against a laser scanner (Meguro et al., section "
      "on the 2nd update).</p>\n";
}

void AppendRangeScale(std::string& page) {
  page += "<div class=\"scale\">";
  for (const float range_m : {1.0F, 1.5F, 2.0F, 3.0F, 4.0F, 6.0F, 8.0F, 12.0F, 20.0F}) {
    const Rgb c = RangeColour(range_m);
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "<i style=\"background:#%02x%02x%02x\"></i>%g m", c[0],
                  c[1], c[2], static_cast<double>(range_m));
    page.append("<span>").append(text.data()).append("</span>");
  }
  page += "<span><i style=\"background:#000000\"></i>unknown</span></div>\n";
}

void AppendSamples(std::string& page, const std::vector<ReportSample>& samples) {
  if (samples.empty()) return;
  page += "<h2>Distance images</h2>\n";
  AppendRangeScale(page);
  for (const ReportSample& sample : samples) {
    page += "<p class=\"sub\">" + HtmlEscaped(sample.frame) + "</p>\n<div class=\"pair\">\n";
    AppendPicture(page, sample.picture);
    AppendPicture(page, sample.ranges);
    page += "</div>\n";
  }
}

void AppendModel(std::string& page, const MapperReport& report) {
  if (report.views.empty() && report.links.empty()) return;
  page += "<h2>Model</h2>\n";
  if (!report.links.empty()) {
    page += "<ul>\n";
    for (const ReportLink& link : report.links) {
      page += "<li><a href=\"" + RelativeUrl(link.path) + "\">" + HtmlEscaped(link.path) + "</a>" +
              (link.what.empty() ? "" : ": " + HtmlEscaped(link.what)) + "</li>\n";
    }
    page += "</ul>\n";
  }
  if (report.views.empty()) return;
  page += "<div class=\"views\">\n";
  for (const ReportPicture& view : report.views) AppendPicture(page, view);
  page += "</div>\n";
}

void AppendWarnings(std::string& page, const std::vector<std::string>& warnings) {
  if (warnings.empty()) return;
  page += "<div class=\"warn\"><b>Warnings</b>\n<ul>\n";
  for (const std::string& warning : warnings) page += "<li>" + HtmlEscaped(warning) + "</li>\n";
  page += "</ul></div>\n";
}

}  // namespace

const char* const kAgainstRenderedTruth =
    "Compared with the true ranges that came with the survey (range/), as kawara-sim renders them "
    "with the pictures; not with a laser scanner as in the paper's Fig. 17, whose own errors would "
    "be added.";

std::string MapperReportPage(const MapperReport& report) {
  // The policy keeps the promise: the browser itself refuses whatever is not in the page.
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      HtmlEscaped(report.title) + "</title>\n<style>" + kMapperReportStyle +
      "</style></head><body>\n<h1>" + HtmlEscaped(report.title) + "</h1>\n";
  std::string sub = HtmlEscaped(report.survey);
  if (report.when) {
    if (!sub.empty()) sub += " \u00B7 ";
    sub += core::FormatIso8601(*report.when, core::Iso8601Digits::kSeconds);
  }
  if (!sub.empty()) page += "<p class=\"sub\">" + sub + "</p>\n";
  AppendWarnings(page, report.warnings);
  if (!report.figures.empty() || !report.options.empty()) {
    page += "<div class=\"tables\">\n";
    AppendRows(page, "Figures", report.figures);
    AppendRows(page, "Options", report.options);
    page += "</div>\n";
  }
  AppendModel(page, report);
  AppendAccuracy(page, report);
  AppendSamples(page, report.samples);
  page += "</body></html>\n";
  return page;
}

}  // namespace kawara::mapper
