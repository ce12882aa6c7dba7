#include "core/config/problems.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace kawara::core::config {
namespace {

/// Insertions, deletions, substitutions and swaps of neighbours (optimal string alignment).
std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), previous(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitution = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, substitution});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    before = previous;
    previous = row;
  }
  return previous[b.size()];
}

}  // namespace

void Problems::Add(const Place& place, std::string text) {
  problems_.push_back({place, std::move(text)});
}

std::string Problems::Text() const {
  std::vector<Problem> sorted = problems_;
  const auto key = [](const Problem& p) {
    return std::tie(p.place.source, p.place.line, p.place.column, p.text);
  };
  std::sort(sorted.begin(), sorted.end(), [&](const Problem& a, const Problem& b) {
    const bool a_set = a.place.line == 0, b_set = b.place.line == 0;
    return a_set != b_set ? b_set : key(a) < key(b);
  });
  std::string all, last;
  for (const Problem& p : sorted) {
    std::string line = p.place.source;
    if (p.place.line > 0) {
      line += ":" + std::to_string(p.place.line) + ":" + std::to_string(p.place.column);
    }
    line += ": " + p.text;
    if (line == last) continue;
    if (!all.empty()) all += '\n';
    all += line;
    last = std::move(line);
  }
  return all;
}

const char* NearestName(const std::string& name, const std::vector<const char*>& candidates) {
  const char* nearest = nullptr;
  if (name.size() > 64) return nearest;
  std::size_t best = std::max<std::size_t>(2, name.size() / 2);  // half of the letters may be wrong
  for (const char* candidate : candidates) {
    const std::size_t distance = EditDistance(name, candidate);
    if (distance < best || (nearest == nullptr && distance == best && distance < name.size())) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string JoinNames(const std::vector<const char*>& names) {
  std::string all;
  for (const char* name : names) all += (all.empty() ? "" : ", ") + std::string(name);
  return all;
}

}  // namespace kawara::core::config
