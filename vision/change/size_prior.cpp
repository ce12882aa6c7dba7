#include "vision/change/size_prior.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

struct ClassSizes {
  core::SizeClass cls;
  double prior;
  bool vehicle;  ///< has plane sides
  std::array<double, 3> mean_m, sd_m;
};

constexpr std::array<ClassSizes, 4> kClasses{{
    {core::SizeClass::kCar, 0.35, true, {4.4, 1.72, 1.65}, {0.55, 0.12, 0.25}},
    {core::SizeClass::kTruck, 0.20, true, {7.2, 2.25, 2.9}, {1.8, 0.20, 0.45}},
    {core::SizeClass::kRubble, 0.20, false, {2.5, 1.8, 0.9}, {1.5, 1.0, 0.4}},
    {core::SizeClass::kPerson, 0.05, false, {0.55, 0.45, 1.65}, {0.2, 0.15, 0.25}},
}};
constexpr double kUnknownPrior = 0.20;
// Any size up to here is as likely as another for a thing of no class [m].
constexpr std::array<double, 3> kUnknownMost{15.0, 6.0, 4.5};
// A hidden part of a thing of no class: this much more, give or take.
constexpr double kUnknownMore = 0.10, kUnknownMoreSd = 0.25;

double LogNormal(double x, double mean, double sd) {
  const double z = (x - mean) / sd;
  return -0.5 * z * z - std::log(sd) - 0.9189385332046727;
}

double UpperTail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

/// Mean and deviation of a normal variable known to be at least `least`.
std::pair<double, double> AtLeast(double mean, double sd, double least) {
  const double a = (least - mean) / sd;
  if (a > 5.0) return {least + sd / a, sd / a};  // far in the tail: exponential
  const double density = std::exp(-0.5 * a * a) / std::sqrt(2.0 * 3.14159265358979);
  const double ratio = density / std::max(1e-300, UpperTail(a));
  const double variance = 1.0 + a * ratio - ratio * ratio;
  return {mean + sd * ratio, sd * std::sqrt(std::max(1e-4, variance))};
}

}  // namespace

SizeGuess GuessSize(const std::array<SeenExtent, 3>& seen, double regular) {
  struct Case {
    core::SizeClass cls;
    double log_weight;
    std::array<double, 3> mean, sd;
  };
  std::vector<Case> cases;
  for (const ClassSizes& c : kClasses) {
    Case one{c.cls, std::log(c.prior), {}, {}};
    // Heaps may look plane by chance, vehicles seldom look like heaps.
    const double plane = c.vehicle ? 0.05 + 0.95 * regular : 1.0 - 0.7 * regular;
    one.log_weight += std::log(plane);
    for (std::size_t i = 0; i < 3; ++i) {
      const double sd = std::hypot(c.sd_m[i], seen[i].sd_m);
      if (seen[i].both_ends) {
        one.log_weight += LogNormal(seen[i].extent_m, c.mean_m[i], sd);
        const double w = c.sd_m[i] * c.sd_m[i] / (sd * sd);
        one.mean[i] = c.mean_m[i] + w * (seen[i].extent_m - c.mean_m[i]);
        one.sd[i] = c.sd_m[i] * std::sqrt(1.0 - w);
      } else {
        // A density as above: of how it was seen by chance up to here.
        const double tail = UpperTail((seen[i].extent_m - c.mean_m[i]) / sd);
        one.log_weight += std::log(std::max(1e-30, tail / std::max(c.mean_m[i], 0.5)));
        std::tie(one.mean[i], one.sd[i]) =
            AtLeast(c.mean_m[i], c.sd_m[i], seen[i].extent_m - seen[i].sd_m);
      }
    }
    cases.push_back(one);
  }
  Case unknown{core::SizeClass::kUnknown, std::log(kUnknownPrior), {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    unknown.log_weight -= std::log(kUnknownMost[i]);
    unknown.mean[i] = seen[i].extent_m + (seen[i].both_ends ? 0.0 : kUnknownMore);
    unknown.sd[i] = seen[i].both_ends ? seen[i].sd_m : std::hypot(seen[i].sd_m, kUnknownMoreSd);
  }
  cases.push_back(unknown);

  double most = cases.front().log_weight;
  for (const Case& c : cases) most = std::max(most, c.log_weight);
  double sum = 0.0;
  for (Case& c : cases) sum += std::exp(c.log_weight - most);
  SizeGuess guess;
  guess.log_evidence = most + std::log(sum);
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  for (const Case& c : cases) {
    const double share = std::exp(c.log_weight - most) / sum;
    if (share > guess.probability) {
      guess.probability = share;
      guess.cls = c.cls;
    }
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      guess.size_m[i] += share * c.mean[k];
      second[i] += share * (c.sd[k] * c.sd[k] + c.mean[k] * c.mean[k]);
    }
  }
  guess.sd_m = (second - guess.size_m.cwiseAbs2()).cwiseMax(1e-6).cwiseSqrt();
  return guess;
}

}  // namespace kawara::vision
