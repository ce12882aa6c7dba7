#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace kawara::sim {

/// What a set of errors amounts to, in the errors' unit. All NaN where there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0.0;    ///< the bias
  double sd = 0.0;      ///< about the mean
  double rms = 0.0;     ///< about zero
  double median = 0.0;  ///< of the absolute values
  double p95 = 0.0;     ///< of the absolute values, nearest rank
  double max = 0.0;     ///< of the absolute values
};

ErrorStatistics Summarise(const std::vector<double>& errors);

/// A table of statistics for people (Text) and for programs (Json): rows are added under names,
/// with the unit of their values.
class ErrorReport {
 public:
  void Add(std::string name, std::string unit, const ErrorStatistics& statistics);
  /// A single number, e.g. a share or a count.
  void Add(std::string name, std::string unit, double value);
  /// Aligned columns: name, n, mean, sd, rms, median, 95 %, max, unit.
  std::string Text() const;
  /// {"name": {"unit": "m", "n": 3, "mean": ...}, "other": {"unit": "1", "value": 0.5}}; NaN is
  /// null.
  std::string Json() const;

 private:
  struct Row {
    std::string name;
    std::string unit;
    ErrorStatistics statistics;
    bool is_single = false;
    double value = 0.0;
  };
  std::vector<Row> rows_;
};

}  // namespace kawara::sim
