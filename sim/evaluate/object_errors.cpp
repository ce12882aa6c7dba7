#include "sim/evaluate/object_errors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace kawara::sim {
namespace {

struct Candidate {
  std::size_t truth = 0;
  std::size_t result = 0;
  double overlap = 0.0;
  double distance_m = 0.0;
};

double Distance(const ApexBox& a, const ApexBox& b) {
  return (a.Centre() - b.Centre()).head<2>().norm();
}

/// Headings of boxes are the same after half a turn.
double HeadingError(const ApexBox& truth, const ApexBox& result) {
  double error = std::remainder(result.Heading() - truth.Heading(), core::kPi);
  return error * core::kDegFromRad;
}

/// Root mean square over the eight apexes, each to the nearest of the same level.
double ApexError(const ApexBox& truth, const ApexBox& result) {
  double squares = 0.0;
  for (const std::size_t level : {std::size_t{0}, std::size_t{4}}) {
    for (std::size_t i = level; i < level + 4; ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t k = level; k < level + 4; ++k) {
        nearest = std::min(nearest, (truth.apexes_enu_m[i] - result.apexes_enu_m[k]).squaredNorm());
      }
      squares += nearest;
    }
  }
  return std::sqrt(squares / 8.0);
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> MatchBoxes(const std::vector<ApexBox>& truth,
                                                            const std::vector<ApexBox>& result,
                                                            double max_distance_m) {
  std::vector<Candidate> candidates;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t r = 0; r < result.size(); ++r) {
      const Candidate c{t, r, IntersectionOverUnion(truth[t], result[r]),
                        Distance(truth[t], result[r])};
      if (c.overlap > 0 || c.distance_m < max_distance_m) candidates.push_back(c);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    if (a.overlap != b.overlap) return a.overlap > b.overlap;
    return a.distance_m < b.distance_m;
  });
  std::vector<bool> truth_taken(truth.size()), result_taken(result.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const Candidate& c : candidates) {
    if (truth_taken[c.truth] || result_taken[c.result]) continue;
    truth_taken[c.truth] = result_taken[c.result] = true;
    pairs.emplace_back(c.truth, c.result);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

ErrorReport CompareObjects(const std::vector<ApexBox>& truth, const std::vector<ApexBox>& result,
                           double max_distance_m) {
  const auto pairs = MatchBoxes(truth, result, max_distance_m);
  std::vector<double> centre, height, length, width, tall, heading, apex, overlap;
  for (const auto& [t, r] : pairs) {
    const Eigen::Vector3d off = result[r].Centre() - truth[t].Centre();
    const Eigen::Vector3d size = result[r].Size() - truth[t].Size();
    centre.push_back(off.head<2>().norm());
    height.push_back(off.z());
    length.push_back(size.x());
    width.push_back(size.y());
    tall.push_back(size.z());
    heading.push_back(HeadingError(truth[t], result[r]));
    apex.push_back(ApexError(truth[t], result[r]));
    overlap.push_back(IntersectionOverUnion(truth[t], result[r]));
  }
  ErrorReport report;
  report.Add("found", "objects", static_cast<double>(pairs.size()));
  report.Add("missed", "objects", static_cast<double>(truth.size() - pairs.size()));
  report.Add("false", "objects", static_cast<double>(result.size() - pairs.size()));
  report.Add("centre, in the plane", "m", Summarise(centre));
  report.Add("centre, height", "m", Summarise(height));
  report.Add("length", "m", Summarise(length));
  report.Add("width", "m", Summarise(width));
  report.Add("height", "m", Summarise(tall));
  report.Add("heading", "deg", Summarise(heading));
  report.Add("apexes", "m", Summarise(apex));
  report.Add("overlap (IoU)", "1", Summarise(overlap));
  return report;
}

std::string ListObjects(const std::vector<ApexBox>& truth, const std::vector<ApexBox>& result,
                        double max_distance_m) {
  const auto pairs = MatchBoxes(truth, result, max_distance_m);
  std::vector<bool> found(truth.size()), right(result.size());
  std::string text;
  for (const auto& [t, r] : pairs) {
    found[t] = right[r] = true;
    char line[400];
    std::snprintf(line, sizeof(line),
                  "found  %.100s (%.40s) as %.100s: centre %.2f m, overlap %.2f\n",
                  truth[t].id.c_str(), truth[t].cls.c_str(), result[r].id.c_str(),
                  Distance(truth[t], result[r]), IntersectionOverUnion(truth[t], result[r]));
    text += line;
  }
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (!found[t]) text += "missed " + truth[t].id + " (" + truth[t].cls + ")\n";
  }
  for (std::size_t r = 0; r < result.size(); ++r) {
    if (!right[r]) text += "false  " + result[r].id + " (" + result[r].cls + ")\n";
  }
  return text;
}

}  // namespace kawara::sim
