#pragma once
#include <string>

#include "onboard/mapper/report/error_histogram.hpp"

namespace kawara::mapper {

/// Half the width [mm] of a drawing that shows at least 95 % of these errors: a round number.
int HistogramReachMm(const ErrorHistogram& errors);

/// The errors in [-reach_mm, reach_mm) as an inline SVG element: 40 bars, the share of all errors
/// upwards, what lies beyond said in words. `title`: plain text above it.
std::string HistogramSvg(const ErrorHistogram& errors, int reach_mm, const std::string& title);

}  // namespace kawara::mapper
