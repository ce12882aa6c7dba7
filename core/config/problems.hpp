#pragma once
#include <string>
#include <vector>

namespace kawara::core::config {

/// Where a value was written. From a file: source is its path, line and column count from 1.
/// From the command line: source is "--set ..." and line is 0.
struct Place {
  std::string source;
  int line = 0;
  int column = 0;
};

/// All mistakes of one configuration, told together.
class Problems {
 public:
  /// `text` is "dotted.key = value: expected ..." or, for the document as a whole, just what is
  /// wrong.
  void Add(const Place& place, std::string text);
  bool empty() const { return problems_.empty(); }
  std::size_t size() const { return problems_.size(); }
  /// One line each, "path:line:column: text", sorted by place (files before command line), doubles
  /// removed.
  std::string Text() const;

 private:
  struct Problem {
    Place place;
    std::string text;
  };
  std::vector<Problem> problems_;
};

/// The candidate with the smallest edit distance, or nullptr if none is near enough to be a slip of
/// the pen.
const char* NearestName(const std::string& name, const std::vector<const char*>& candidates);

/// "a, b, c"
std::string JoinNames(const std::vector<const char*>& names);

}  // namespace kawara::core::config
