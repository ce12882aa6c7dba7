#include "onboard/mapper/report/report_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <vector>

#include "core/base64.hpp"
#include "core/iso8601.hpp"
#include "onboard/mapper/report/histogram_svg.hpp"
#include "onboard/mapper/report/range_colours.hpp"

namespace kawara::mapper {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Tags that were opened and not closed in their order; empty: the page is well nested.
std::string BadlyNested(const std::string& page) {
  const std::vector<std::string> open_by_nature{"meta", "img", "br"};
  std::string text = std::regex_replace(page, std::regex("<style>[^<]*</style>"), "");
  std::vector<std::string> open;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    if (text.compare(at, 2, "<!") == 0) continue;
    const std::size_t end = text.find('>', at);
    if (end == std::string::npos) return "unfinished tag";
    const std::string whole = text.substr(at, end - at + 1);
    const bool closes = whole[1] == '/';
    const std::size_t from = closes ? 2 : 1;
    const std::string name = whole.substr(from, whole.find_first_of(" />", from) - from);
    if (closes) {
      if (open.empty() || open.back() != name) return "</" + name + ">";
      open.pop_back();
    } else if (text[end - 1] != '/' && std::find(open_by_nature.begin(), open_by_nature.end(),
                                                 name) == open_by_nature.end()) {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : "<" + open.back() + ">";
}

vision::RangeImage Ranges() {
  vision::RangeImage ranges;
  ranges.Reset(4, 2);
  for (std::size_t i = 0; i < 7; ++i) {
    ranges.range_m[i] = 2.0F + static_cast<float>(i);
    ranges.sd_m[i] = 0.1F;
  }
  return ranges;
}

MapperReport Full(const std::string& text) {
  const std::vector<std::uint8_t> grey(3 * 16 * 8, 128);
  const vision::ConstImageView view{grey.data(), 16, 8};
  MapperReport report;
  report.title = report.survey = report.accuracy_against = text;
  report.when = *core::ParseIso8601("2026-03-04T05:06:07Z");
  report.warnings = {text};
  report.figures = report.options = {{text, text, text}};
  report.accuracy.emplace().Add(Ranges(), std::vector<float>(8, 3.0F));
  report.samples = {{text, PhotoForReport(view, text), RangesForReport(Ranges(), text)}};
  report.views = {PngForReport(view, text)};
  report.views.back().px_per_m = 3.0;
  report.links = {{text, text}};
  return report;
}

TEST(MapperReportPage, OfNothingButATitleIsWhole) {
  MapperReport report;
  report.title = "A drive";
  const std::string page = MapperReportPage(report);
  EXPECT_EQ(page.rfind("<!DOCTYPE html>\n<html lang=\"en\">", 0), 0U);
  EXPECT_THAT(page, HasSubstr("<title>A drive</title>"));
  EXPECT_THAT(page, HasSubstr("<h1>A drive</h1>"));
  EXPECT_THAT(page, Not(HasSubstr("<h2>")));
  EXPECT_EQ(BadlyNested(page), "");
}

TEST(MapperReportPage, WithEverythingIsWellNested) {
  const std::string page = MapperReportPage(Full("drive 7"));
  EXPECT_EQ(BadlyNested(page), "");
  for (const char* heading : {"Figures", "Options", "Model", "Accuracy", "Distance images"}) {
    EXPECT_THAT(page, HasSubstr(std::string("<h2>") + heading + "</h2>"));
  }
  EXPECT_THAT(page, HasSubstr("2026-03-04T05:06:07Z"));
}

TEST(MapperReportPage, NoTextCanBecomeATag) {
  const std::string page = MapperReportPage(Full("\"><script>alert('x')</script>&"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("alert('x')")));
  EXPECT_EQ(BadlyNested(page), "");
}

TEST(MapperReportPage, NeedsNothingFromElsewhere) {
  const std::string page = MapperReportPage(Full("drive"));
  const std::regex reference(R"re((?:src|href|url|action|data)\s*[=(]\s*"?([^"\s)>]{0,12}))re");
  int references = 0;
  for (std::sregex_iterator it(page.begin(), page.end(), reference), end; it != end; ++it) {
    const std::string where = (*it)[1];
    EXPECT_TRUE(where.rfind("data:image/", 0) == 0 || where.rfind("./", 0) == 0) << where;
    ++references;
  }
  EXPECT_EQ(references, 4);  // three pictures and a link
  EXPECT_THAT(page, Not(HasSubstr("http:")));
  EXPECT_THAT(page, Not(HasSubstr("https:")));
  EXPECT_THAT(page, Not(HasSubstr("@import")));
}

TEST(MapperReportPage, LinksStayBelowThePage) {
  const struct {
    const char *path, *url;
  } cases[]{{"tiles/0_1.glb", "./tiles/0_1.glb"},
            {"javascript:alert(1)", "./javascript%3Aalert%281%29"},
            {"//host/x", "./host/x"},
            {"a b#c?d%.wrl", "./a%20b%23c%3Fd%25.wrl"},
            {"\xE7\x93\xA6.las", "./%E7%93%A6.las"}};
  for (const auto& [path, url] : cases) {
    MapperReport report;
    report.links = {{path, ""}};
    EXPECT_THAT(MapperReportPage(report), HasSubstr(std::string("<a href=\"") + url + "\">"));
  }
}

TEST(MapperReportPage, PicturesAreThereToTheLastByte) {
  const MapperReport report = Full("drive");
  const auto& bytes = report.samples[0].ranges.bytes;
  const std::string coded =
      core::Base64({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  EXPECT_THAT(MapperReportPage(report), HasSubstr("src=\"data:image/png;base64," + coded + "\""));
}

TEST(MapperReportPage, TellsTheFiguresOfTheAccuracy) {
  MapperReport report;
  vision::RangeImage ranges;
  ranges.Reset(2, 1);
  ranges.range_m = {3.125F, 2.875F};  // errors of 125 mm, exact in binary
  ranges.sd_m = {0.1F, 0.1F};
  report.accuracy.emplace().Add(ranges, std::vector<float>{3.0F, 3.0F});
  const std::string page = MapperReportPage(report);
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">2\u20134 m</th><td>125.0 mm</td>"));
  EXPECT_THAT(page, HasSubstr("<td>0.0 mm</td><td>0.00 %</td><td>100.0 %</td><td>100.0 %</td>"
                              "<td>2</td>"));
  // Bands without a pixel have dashes and no drawing.
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">6\u20138 m</th><td>\u2013</td>"));
  EXPECT_THAT(page, Not(HasSubstr("<title>6\u20138 m</title>")));
}

TEST(MapperReportPage, SameReportSameBytes) {
  EXPECT_EQ(MapperReportPage(Full("drive")), MapperReportPage(Full("drive")));
}

TEST(HistogramSvg, BarsHoldTheSharesAndWordsTheRest) {
  ErrorHistogram errors;
  for (int i = 0; i < 6; ++i) errors.Add(0.0105);   // bar of 10 to 15 mm
  for (int i = 0; i < 3; ++i) errors.Add(-0.0895);  // of -90 to -85 mm
  errors.Add(0.5);
  const std::string svg = HistogramSvg(errors, 100, "a & b");
  EXPECT_THAT(svg, HasSubstr("a &amp; b"));
  EXPECT_THAT(svg, HasSubstr("beyond: 10 %"));
  EXPECT_THAT(svg, HasSubstr(">100 %</text>"));  // 60 % is drawn on a scale to 100
  std::vector<double> heights;
  const std::regex bar(R"re(<rect [^>]*height="([0-9.]+)")re");
  for (std::sregex_iterator it(svg.begin(), svg.end(), bar), end; it != end; ++it) {
    heights.push_back(std::stod((*it)[1]));
  }
  ASSERT_EQ(heights.size(), 2U);
  EXPECT_NEAR(heights[1] / heights[0], 2.0, 1e-2);
}

TEST(HistogramSvg, ReachShowsNearlyAll) {
  ErrorHistogram errors;
  for (int i = 0; i < 96; ++i) errors.Add(0.0555);
  for (int i = 0; i < 4; ++i) errors.Add(3.0);
  EXPECT_EQ(HistogramReachMm(errors), 60);
  EXPECT_EQ(HistogramReachMm(ErrorHistogram()), 20);
}

TEST(RangeColours, NearIsRedFarIsBlueUnknownBlack) {
  const Rgb near = RangeColour(1.2F), far = RangeColour(15.0F);
  EXPECT_GT(near[0], 2 * near[2]);
  EXPECT_GT(far[2], far[0]);
  EXPECT_EQ(RangeColour(vision::RangeImage::kUnknown), (Rgb{0, 0, 0}));
  EXPECT_EQ(RangeColour(0.1F), RangeColour(1.0F));
  EXPECT_EQ(RangeColour(1e9F), RangeColour(20.0F));
}

TEST(ReportPicture, IsScaledToTheWidthAskedForAndNeverUp) {
  const std::vector<std::uint8_t> grey(3 * 1000 * 500, 90);
  EXPECT_EQ(PhotoForReport({grey.data(), 1000, 500}, "", 480).width_px, 480);
  EXPECT_EQ(PhotoForReport({grey.data(), 1000, 500}, "", 480).height_px, 240);
  EXPECT_EQ(PhotoForReport({grey.data(), 100, 50}, "", 480).width_px, 100);
  EXPECT_EQ(RangesForReport(Ranges(), "", 2).height_px, 1);
}

TEST(ReportPicture, OfNothingIsNone) {
  EXPECT_TRUE(PhotoForReport({}, "").bytes.empty());
  EXPECT_TRUE(RangesForReport({}, "").bytes.empty());
  EXPECT_TRUE(PngForReport({}, "").bytes.empty());
}

}  // namespace
}  // namespace kawara::mapper
