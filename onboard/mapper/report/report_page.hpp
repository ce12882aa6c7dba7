#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/time.hpp"
#include "onboard/mapper/report/accuracy.hpp"
#include "onboard/mapper/report/report_picture.hpp"

namespace kawara::mapper {

struct ReportRow {
  std::string name, value, unit;
};

/// A frame and what was measured from it.
struct ReportSample {
  std::string frame;
  ReportPicture picture, ranges;  ///< PhotoForReport, RangesForReport
};

/// A file beside the page.
struct ReportLink {
  std::string path;  ///< from the page's folder, '/' between parts
  std::string what;
};

/// What the mapper has to say about a run. Texts are plain; whatever is empty is left out of the
/// page.
struct MapperReport {
  std::string title;
  std::string survey;  ///< where the pictures came from
  std::optional<core::UtcTime> when;
  std::vector<std::string> warnings;
  std::vector<ReportRow> figures;  ///< what came out
  std::vector<ReportRow> options;  ///< what was asked for
  std::optional<Accuracy> accuracy;
  std::string accuracy_against;  ///< what the ranges were compared with, a sentence
  std::vector<ReportSample> samples;
  std::vector<ReportPicture> views;  ///< of the model (model_view.hpp)
  std::vector<ReportLink> links;     ///< the model's files
};

/// Comparison with a survey's true ranges (truth_ranges.hpp), in a sentence. The paper took a laser
/// scanner for truth; a survey folder has none, and the page says so.
extern const char* const kAgainstRenderedTruth;

/// The report as ONE page of HTML that needs no script, no network and no other file: pictures are
/// data URIs, drawings inline SVG. Reads well at 400 px and on paper. The same report gives the
/// same bytes.
std::string MapperReportPage(const MapperReport& report);

/// The page's style sheet.
extern const char* const kMapperReportStyle;

}  // namespace kawara::mapper
