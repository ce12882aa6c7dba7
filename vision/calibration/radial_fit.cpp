#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/calibration/first_guess.hpp"

/// One model's radii by another's.
namespace kawara::vision {
namespace {

constexpr int kSamples = 80;
constexpr int kIterations = 100;
/// Minima of a model whose numbers of shape differ by less are one.
constexpr double kSameShape = 0.1;
constexpr std::size_t kMostMinima = 4;

struct Sample {
  double angle_rad, radius_px;
};

/// Models that have a focal length of their own scale with it.
double RadiusPx(CalibrationModel model, const CalibrationPicture& picture, const Eigen::VectorXd& p,
                double angle_rad) {
  const bool in_px = model == CalibrationModel::kOcam || model == CalibrationModel::kDoughnut ||
                     model == CalibrationModel::kDoughnutCorrected;
  return (in_px ? 1.0 : p[2]) * TrialCamera(model, picture, p).Radius(angle_rad);
}

/// Which numbers the radius depends on.
std::vector<Eigen::Index> RadialNumbers(CalibrationModel model) {
  switch (model) {
    case CalibrationModel::kDoughnut:
      return {3, 4};
    case CalibrationModel::kDoughnutCorrected:
      return {3, 4, 5, 6, 7};
    case CalibrationModel::kOcam:
      return {4, 5, 6, 7};
    case CalibrationModel::kMei:
      return {2, 4, 5, 6};
    case CalibrationModel::kDoubleSphere:
    case CalibrationModel::kEucm:
      return {2, 4, 5};
    default:
      return {2, 4, 5, 6, 7};
  }
}

/// What a model's shape may be, to begin with: its numbers from the fourth on.
std::vector<std::vector<double>> ShapesOf(CalibrationModel model) {
  switch (model) {
    case CalibrationModel::kMei:
      return {{0.3, 0, 0}, {0.7, 0, 0}, {1.0, 0, 0}, {1.5, 0, 0}, {2.5, 0, 0}};
    case CalibrationModel::kDoubleSphere: {
      std::vector<std::vector<double>> shapes;
      for (const double xi : {-0.4, 0.0, 0.4, 0.8, 0.95}) {
        for (const double alpha : {0.2, 0.5, 0.7, 0.9}) shapes.push_back({xi, alpha});
      }
      return shapes;
    }
    case CalibrationModel::kEucm: {
      std::vector<std::vector<double>> shapes;
      for (const double alpha : {0.3, 0.5, 0.7, 0.9}) {
        for (const double beta : {0.5, 1.0, 2.0}) shapes.push_back({alpha, beta});
      }
      return shapes;
    }
    default:
      return {{0, 0, 0, 0}};
  }
}

class RadialFit {
 public:
  RadialFit(CalibrationModel model, const CalibrationPicture& picture, std::vector<Sample> samples)
      : model_(model),
        picture_(picture),
        samples_(std::move(samples)),
        info_(TrialCamera::ParametersOf(model, picture)),
        free_(RadialNumbers(model)) {}

  /// The sum of squares, with `p` moved to the nearest least one. Not finite: out of the domain.
  double Minimise(Eigen::VectorXd& p) const {
    Eigen::VectorXd r;
    double cost = Residuals(p, r), damping = 1e-3;
    if (!std::isfinite(cost)) return cost;
    const auto n = static_cast<Eigen::Index>(free_.size());
    Eigen::MatrixXd J(r.size(), n);
    for (int i = 0; i < kIterations && damping < 1e10; ++i) {
      for (Eigen::Index k = 0; k < n; ++k) {
        Eigen::VectorXd beside = p, moved;
        const TrialParameter& info = Info(k);
        const double step = p[Number(k)] + info.step > info.high ? -info.step : info.step;
        beside[Number(k)] += step;
        Residuals(beside, moved);
        J.col(k) = (r - moved) / step;
      }
      if (!J.allFinite()) return cost;
      Eigen::MatrixXd normal = J.transpose() * J;
      const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
      normal = scale.asDiagonal() * normal * scale.asDiagonal();
      const Eigen::VectorXd right = scale.asDiagonal() * (J.transpose() * r);
      double gain = 0.0;
      while (damping < 1e10) {
        Eigen::MatrixXd damped = normal;
        damped.diagonal().array() += damping;
        const Eigen::VectorXd step = scale.asDiagonal() * damped.ldlt().solve(right);
        Eigen::VectorXd next = p, next_r;
        for (Eigen::Index k = 0; k < n; ++k) {
          next[Number(k)] = std::clamp(p[Number(k)] + step[k], Info(k).low, Info(k).high);
        }
        const double next_cost = Residuals(next, next_r);
        if (!(next_cost < cost)) {
          damping *= 5.0;
          continue;
        }
        gain = (cost - next_cost) / cost;
        cost = next_cost;
        p = next;
        r = next_r;
        damping = std::max(1e-12, 0.2 * damping);
        break;
      }
      if (gain < 1e-9) return cost;
    }
    return cost;
  }

 private:
  Eigen::Index Number(Eigen::Index k) const { return free_[static_cast<std::size_t>(k)]; }
  const TrialParameter& Info(Eigen::Index k) const {
    return info_[static_cast<std::size_t>(Number(k))];
  }
  double Residuals(const Eigen::VectorXd& p, Eigen::VectorXd& r) const {
    r.resize(static_cast<Eigen::Index>(samples_.size()));
    Eigen::Index i = 0;
    for (const Sample& s : samples_) {
      r[i++] = s.radius_px - RadiusPx(model_, picture_, p, s.angle_rad);
    }
    return r.squaredNorm();
  }

  CalibrationModel model_;
  const CalibrationPicture& picture_;
  std::vector<Sample> samples_;
  std::vector<TrialParameter> info_;
  std::vector<Eigen::Index> free_;
};

/// F(r) = r cot(angle) is linear in an OCam's coefficients.
void SolveOcam(const CalibrationPicture& picture, const std::vector<Sample>& samples,
               Eigen::VectorXd& p) {
  const double unit = 0.5 * std::min(picture.width_px, picture.height_px);
  const auto n = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd A(n, 4);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Sample& s = samples[static_cast<std::size_t>(i)];
    const double r = s.radius_px / unit, sine = std::sin(s.angle_rad);
    A.row(i) << sine, sine * r * r, sine * r * r * r, sine * r * r * r * r;
    b[i] = s.radius_px * std::cos(s.angle_rad);
  }
  const Eigen::VectorXd a = A.colPivHouseholderQr().solve(b);
  // a_n r^n = p_n unit (r / unit)^n.
  p[4] = std::max(1.0, a[0]);
  p[5] = a[1] / unit;
  p[6] = a[2] / unit;
  p[7] = a[3] / unit;
}

struct Minimum {
  double cost;
  Eigen::VectorXd numbers;
};

/// The lowest, and others whose shape is another, lowest first.
std::vector<Eigen::VectorXd> Distinct(std::vector<Minimum> minima) {
  std::ranges::stable_sort(minima, std::ranges::less(), &Minimum::cost);
  std::vector<Eigen::VectorXd> distinct;
  for (const Minimum& minimum : minima) {
    const bool known = std::ranges::any_of(distinct, [&](const Eigen::VectorXd& other) {
      const auto shape = other.size() - 4;
      return (other.tail(shape) - minimum.numbers.tail(shape)).cwiseAbs().maxCoeff() < kSameShape;
    });
    if (!known) distinct.push_back(minimum.numbers);
    if (distinct.size() == kMostMinima) break;
  }
  return distinct;
}

}  // namespace

std::vector<Eigen::VectorXd> ConvertCamera(CalibrationModel from, const Eigen::VectorXd& numbers,
                                           CalibrationModel model,
                                           const CalibrationPicture& picture,
                                           const AngleRange& seen) {
  const double aspect = from == CalibrationModel::kDoughnut ||
                                from == CalibrationModel::kDoughnutCorrected ||
                                from == CalibrationModel::kOcam
                            ? numbers[2]
                            : numbers[3] / numbers[2];
  std::vector<Sample> samples;
  for (int i = 0; i <= kSamples; ++i) {
    const double angle = seen.low_rad + (seen.high_rad - seen.low_rad) * i / kSamples;
    samples.push_back({angle, RadiusPx(from, picture, numbers, angle)});
  }
  const auto info = TrialCamera::ParametersOf(model, picture);
  const RadialFit fit(model, picture, samples);
  const Sample& middle = samples[samples.size() / 2];
  std::vector<Minimum> minima;
  for (const auto& shape : ShapesOf(model)) {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(info.size()));
    p[0] = numbers[0];
    p[1] = numbers[1];
    switch (model) {
      case CalibrationModel::kDoughnut:
      case CalibrationModel::kDoughnutCorrected: {
        const Sample &a = samples.front(), &b = samples.back();
        p[2] = aspect;
        p[4] = std::max(1.0, (b.radius_px - a.radius_px) / (b.angle_rad - a.angle_rad));
        p[3] = a.radius_px + p[4] * (core::kPi / 2 - a.angle_rad);
        break;
      }
      case CalibrationModel::kOcam:
        p[2] = aspect;
        p[4] = 1.0;
        SolveOcam(picture, samples, p);
        break;
      default:
        for (std::size_t i = 0; i < shape.size() && i + 4 < info.size(); ++i) {
          p[4 + static_cast<Eigen::Index>(i)] = shape[i];
        }
        p[2] = 1.0;
        p[2] = middle.radius_px / RadiusPx(model, picture, p, middle.angle_rad);
    }
    if (!p.allFinite()) continue;
    const double cost = fit.Minimise(p);
    if (!std::isfinite(cost)) continue;
    if (model != CalibrationModel::kOcam && model != CalibrationModel::kDoughnut &&
        model != CalibrationModel::kDoughnutCorrected) {
      p[3] = p[2] * aspect;
    }
    minima.push_back({cost, p});
  }
  return Distinct(std::move(minima));
}

}  // namespace kawara::vision
