#include "vision/change/side_profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kawara::vision {

void SideProfile::Fill(std::span<const double> at_m, std::span<const double> weight) {
  const auto [low, high] = std::minmax_element(at_m.begin(), at_m.end());
  const double room = 4.0 * smooth_m_;
  first_m_ = *low - room;
  const auto bins = static_cast<std::size_t>(std::ceil((*high + room - first_m_) / step_m_)) + 1;
  raw_.assign(bins, 0.0);
  sum_ = 0.0;
  for (std::size_t i = 0; i < at_m.size(); ++i) {
    // Shared between the two nearest bins.
    const double place = (at_m[i] - first_m_) / step_m_ - 0.5;
    const double base = std::floor(place), part = place - base;
    const auto bin = static_cast<std::size_t>(std::max(0.0, base));
    raw_[bin] += weight[i] * (1.0 - part);
    if (bin + 1 < bins) raw_[bin + 1] += weight[i] * part;
    sum_ += weight[i];
  }
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3.0 * smooth_m_ / step_m_));
  std::vector<double> kernel;
  double total = 0.0;
  for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
    const double z = static_cast<double>(k) * step_m_ / smooth_m_;
    kernel.push_back(std::exp(-0.5 * z * z));
    total += kernel.back();
  }
  density_.assign(bins, 0.0);
  for (std::size_t i = 0; i < bins; ++i) {
    if (raw_[i] == 0.0) continue;
    for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(bins)) continue;
      density_[static_cast<std::size_t>(j)] +=
          raw_[i] * kernel[static_cast<std::size_t>(k + reach)] / total;
    }
  }
}

double SideProfile::Quantile(double share) const {
  double below = 0.0;
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    if (below + raw_[i] >= share * sum_ && raw_[i] > 0.0) {
      const double part = (share * sum_ - below) / raw_[i];
      return first_m_ + (static_cast<double>(i) + part) * step_m_;
    }
    below += raw_[i];
  }
  return first_m_ + static_cast<double>(raw_.size()) * step_m_;
}

double SideProfile::Edge(bool upper) const {
  std::vector<double> typical;
  for (const double d : density_)
    if (d > 0.05 * sum_ / static_cast<double>(density_.size())) typical.push_back(d);
  if (typical.empty()) return Quantile(upper ? 1.0 : 0.0);
  const auto middle = typical.begin() + static_cast<std::ptrdiff_t>(typical.size() / 2);
  std::nth_element(typical.begin(), middle, typical.end());
  const double half = 0.5 * *middle;
  const std::size_t bins = density_.size();
  for (std::size_t k = 0; k < bins; ++k) {
    const std::size_t i = upper ? bins - 1 - k : k;
    if (density_[i] < half) continue;
    // Between this bin and the one outside of it.
    double beyond = 0.5;
    if (k > 0) {
      const double outer = density_[upper ? i + 1 : i - 1];
      beyond = (density_[i] - half) / std::max(1e-12, density_[i] - outer);
    }
    const double centre = first_m_ + (static_cast<double>(i) + 0.5) * step_m_;
    return upper ? centre + beyond * step_m_ : centre - beyond * step_m_;
  }
  return Quantile(upper ? 1.0 : 0.0);
}

SidePeak SideProfile::Peak(double depth_m, bool upper) const {
  constexpr double kStray = 0.01;
  SidePeak peak;
  const double low = Quantile(kStray), high = Quantile(1.0 - kStray);
  peak.outermost_m = upper ? high : low;
  peak.innermost_m = upper ? low : high;
  // The outer part, at most two fifths of the whole: further in is the other side's.
  const double depth = std::min(depth_m, 0.4 * (high - low));
  const double begin = upper ? high - depth : low - 2.0 * smooth_m_;
  const double end = upper ? high + 2.0 * smooth_m_ : low + depth;
  const auto bin_of = [&](double m) {
    return static_cast<std::size_t>(
        std::clamp((m - first_m_) / step_m_, 0.0, static_cast<double>(density_.size() - 1)));
  };
  std::size_t best = bin_of(begin);
  for (std::size_t i = bin_of(begin); i <= bin_of(end); ++i)
    if (density_[i] > density_[best]) best = i;
  // Parabola through the peak and its neighbours.
  double offset = 0.0;
  if (best > 0 && best + 1 < density_.size()) {
    const double a = density_[best - 1], b = density_[best], c = density_[best + 1];
    const double bend = a - 2.0 * b + c;
    if (bend < 0.0) offset = std::clamp(0.5 * (a - c) / bend, -0.5, 0.5);
  }
  peak.at_m = first_m_ + (static_cast<double>(best) + 0.5 + offset) * step_m_;
  const double mean = sum_ * step_m_ / std::max(high - low, step_m_);
  peak.sharpness = density_[best] / std::max(1e-12, mean);
  return peak;
}

}  // namespace kawara::vision
