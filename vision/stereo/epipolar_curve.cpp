#include "vision/stereo/epipolar_curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kawara::vision {
namespace {

/// Kernels write whole vectors.
constexpr std::size_t kVector = 16;
/// Between knots where the camera's resolution is the mean [px].
constexpr double kKnotSpacing = 2.0;
/// Knots further from each other are on both sides of a picture's seam [px].
constexpr float kSeam = 64.0F;
constexpr std::size_t kMostSteps = 66;  ///< from a knot to the next
/// For the derivative of a model's Project [rad].
constexpr float kTurn = 1e-3F;

}  // namespace

ArcProjector::ArcProjector(const StereoCamera& camera, const Eigen::Matrix3d& R_camera_frame,
                           const Eigen::Vector3d& up)
    : camera_(camera) {
  Eigen::Matrix3d rotation = R_camera_frame;
  if (camera.projection()) rotation = camera.projection()->R_optical_camera() * rotation;
  rotation_ = rotation.cast<float>();
  up_ = (rotation * up).cast<float>();
}

void ArcProjector::Project(const Eigen::Vector3f& start, const Eigen::Vector3f& turn,
                           const float* cosine, const float* sine, std::size_t count,
                           const paper::ArcPixels& out) const {
  paper::Arc arc{};
  Eigen::Map<Eigen::Vector3f>(arc.start) = rotation_ * start;
  Eigen::Map<Eigen::Vector3f>(arc.turn) = rotation_ * turn;
  Eigen::Map<Eigen::Vector3f>(arc.up) = up_;
  if (camera_.projection()) {
    paper::ProjectArc(camera_.projection()->table(), arc, cosine, sine, count, out);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f ray = Eigen::Map<Eigen::Vector3f>(arc.start) * cosine[i] +
                                Eigen::Map<Eigen::Vector3f>(arc.turn) * sine[i];
    const Eigen::Vector3f upwards = up_ - up_.dot(ray) * ray;
    const auto pixel = camera_.model().Project(ray.cast<double>());
    const auto above = camera_.model().Project((ray + kTurn * upwards).cast<double>());
    const auto below = camera_.model().Project((ray - kTurn * upwards).cast<double>());
    const bool seen = pixel && above && below;
    constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
    out.u_px[i] = seen ? static_cast<float>(pixel->x()) : kNowhere;
    out.v_px[i] = seen ? static_cast<float>(pixel->y()) : kNowhere;
    out.up_u[i] = seen ? static_cast<float>(above->x() - below->x()) : 0.0F;
    out.up_v[i] = seen ? static_cast<float>(above->y() - below->y()) : 0.0F;
  }
}

double EpipolarCurve::KnotSpacing(const StereoCamera& b) {
  return kKnotSpacing / b.mean_px_per_rad();
}

EpipolarCurve::EpipolarCurve(const StereoCamera& b, const EpipolarPair& pair, double nearest_m)
    : projector_(b, pair.b_from_epipolar * pair.a_from_epipolar.transpose(),
                 Eigen::Vector3d::UnitX()),
      e0_(pair.a_from_epipolar.col(0).cast<float>()),
      baseline_m_(static_cast<float>(pair.baseline_m)),
      nearest_m_(static_cast<float>(nearest_m)),
      spacing_rad_(static_cast<float>(KnotSpacing(b))) {
  const auto most = static_cast<std::size_t>(core::kPi / static_cast<double>(spacing_rad_)) + 3;
  const std::size_t room = (most + kVector - 1) / kVector * kVector;
  cosine_.resize(room);
  sine_.resize(room);
  for (std::size_t i = 0; i < room; ++i) {
    const double delta_rad = static_cast<double>(i) * static_cast<double>(spacing_rad_);
    cosine_[i] = static_cast<float>(std::cos(delta_rad));
    sine_[i] = static_cast<float>(std::sin(delta_rad));
  }
  for (auto& knots : knots_) knots.resize(room);
}

std::span<const CurveStep> EpipolarCurve::Follow(const Eigen::Vector3f& ray_a) {
  const float cosine = std::clamp(ray_a.dot(e0_), -1.0F, 1.0F);
  const float sine = std::sqrt(1.0F - cosine * cosine);
  alpha_rad_ = std::atan2(sine, cosine);
  if (!(sine > 1e-4F)) return {};
  const float widest_rad = std::atan2(baseline_m_ * sine, nearest_m_ - baseline_m_ * cosine);
  const auto count =
      std::min(cosine_.size(), static_cast<std::size_t>(widest_rad / spacing_rad_) + 2);
  const Eigen::Vector3f away = (cosine * ray_a - e0_) / sine;
  projector_.Project(ray_a, away, cosine_.data(), sine_.data(), count,
                     {knots_[0].data(), knots_[1].data(), knots_[2].data(), knots_[3].data()});
  const float* const u = knots_[0].data();
  const float* const v = knots_[1].data();
  const float* const up_u = knots_[2].data();
  const float* const up_v = knots_[3].data();
  std::size_t steps = 0;
  float next_px = 0.0F;  // from the knot to the next step
  bool seen = false;
  for (std::size_t k = 0; k + 1 < count; ++k) {
    if (steps_.size() < steps + kMostSteps) steps_.resize(2 * steps + kMostSteps);
    const float du = u[k + 1] - u[k], dv = v[k + 1] - v[k];
    const float length_px = std::sqrt(du * du + dv * dv);
    if (!(length_px < kSeam)) {  // or not seen, NaN
      if (seen) steps_[steps++] = {CurveStep::kGap, CurveStep::kGap, 0.0F, 0.0F, 0.0F};
      seen = false;
      next_px = 0.0F;
      continue;
    }
    seen = true;
    const float per_px = 1.0F / length_px;
    for (; next_px < length_px; next_px += 1.0F) {
      const float t = next_px * per_px;
      const float delta_rad = (static_cast<float>(k) + t) * spacing_rad_;
      if (delta_rad > widest_rad) return {steps_.data(), steps};
      steps_[steps++] = {u[k] + t * du, v[k] + t * dv, up_u[k] + t * (up_u[k + 1] - up_u[k]),
                         up_v[k] + t * (up_v[k + 1] - up_v[k]), delta_rad};
    }
    next_px -= length_px;
  }
  return {steps_.data(), steps};
}

}  // namespace kawara::vision
