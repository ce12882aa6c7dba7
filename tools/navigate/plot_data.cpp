#include "tools/navigate/plot_data.hpp"

#include <algorithm>

namespace kawara::navigate {
namespace {

constexpr std::size_t kMostPoints = 8000;
constexpr std::size_t kMostFixes = 8000;

}  // namespace

void PlotData::Add(const TrajectoryPoint& point) {
  if (points_.empty()) origin_ = point.position;
  if (states_.empty() || states_.back().state != point.state ||
      states_.back().reason != point.reason) {
    if (!states_.empty()) states_.back().end = point.time;
    states_.push_back({point.time, point.time, point.state, point.reason});
  }
  states_.back().end = point.time;
  if (seen_++ % every_ != 0) return;
  if (points_.size() == kMostPoints) {
    for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = points_[2 * i];
    points_.resize(points_.size() / 2);
    every_ *= 2;
    if ((seen_ - 1) % every_ != 0) return;
  }
  points_.push_back(point);
}

void PlotData::AddReferences(const std::vector<Reference>& references,
                             const ReferenceErrors& errors) {
  if (empty()) return;
  const std::size_t every = references.size() / kMostFixes + 1;
  for (std::size_t i = 0; i < references.size(); ++i) {
    const Reference& reference = references[i];
    // What was withheld is what people look for: all of it.
    if (i % every != 0 && reference.role == Reference::Role::kGiven) continue;
    fixes_.push_back({reference.time, core::NedBetween(origin_, reference.antenna), reference.rtk,
                      reference.role, errors.residual(i)});
  }
}

}  // namespace kawara::navigate
