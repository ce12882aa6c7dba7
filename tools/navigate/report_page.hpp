#pragma once
#include <string>
#include <vector>

#include "tools/navigate/plot_data.hpp"

namespace kawara::navigate {

/// The report as one HTML page that needs nothing else: plan, states, height, velocity, attitude,
/// deviations and residuals of the GNSS positions on one time axis. `title` stands above it,
/// `summary` (plain text) below; `blanks` are shaded.
std::string ReportPage(const PlotData& plot, const std::vector<TimeWindow>& blanks,
                       const std::string& title, const std::string& summary);

/// What draws the page: style and script, which know nothing of this run.
extern const char* const kReportStyle;
extern const char* const kReportScript;

}  // namespace kawara::navigate
