#include "vision/camera/radial_projection.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

constexpr int kLeastKnots = 1 << 8;
// A ray this near to the axis or to the rim stands for it: g is even in the distance from the axis
// and smooth at the rim, but not defined on the one and perhaps lost by rounding on the other.
constexpr double kNudge = 1e-9;
// Straight back the picture's radius is not zero while the ray's distance from the axis is: g has a
// pole there. 154 deg from the axis is more than any lens sees.
constexpr double kLeastZ = -0.9;

/// g(z) by the camera's own Project.
class Profile {
 public:
  Profile(const CameraModel& camera, const RadialSymmetry& symmetry)
      : camera_(camera), symmetry_(symmetry), inverse_affine_(symmetry.affine.inverse()) {
    const double nudge = kNudge * (symmetry.z_max - symmetry.z_min);
    inner_min_ = std::max(symmetry.z_min, -1.0 + kNudge) + nudge;
    inner_max_ = std::min(symmetry.z_max, 1.0 - kNudge) - nudge;
  }

  std::optional<double> At(double z) const {
    const double inside = std::clamp(z, inner_min_, inner_max_);
    const double rho = std::sqrt((1.0 - inside) * (1.0 + inside));
    const auto pixel =
        camera_.Project(symmetry_.R_optical_camera.transpose() * Eigen::Vector3d(rho, 0.0, inside));
    if (!pixel) return {};
    return (inverse_affine_ * (*pixel - symmetry_.center_px)).x() / rho;
  }

  /// The picture's farthest corner, on the scale on which a ray has radius rho * g.
  double CornerRadius() const {
    double farthest = 0.0;
    for (const double u : {-0.5, camera_.width_px() - 0.5}) {
      for (const double v : {-0.5, camera_.height_px() - 0.5}) {
        const Eigen::Vector2d corner(u, v);
        farthest = std::max(farthest, (inverse_affine_ * (corner - symmetry_.center_px)).norm());
      }
    }
    return farthest;
  }

  bool IsInside(double z, double radius) const {
    const double rho = std::sqrt(std::max(0.0, (1.0 - z) * (1.0 + z)));
    const auto g = At(z);
    return g && std::abs(*g) * rho <= radius;
  }

 private:
  const CameraModel& camera_;
  const RadialSymmetry& symmetry_;
  Eigen::Matrix2d inverse_affine_;
  double inner_min_, inner_max_;
};

/// The end of the field of view nearest to `outside` from which rays still fall inside the circle;
/// the radius is monotonic in z.
double Narrowed(const Profile& profile, double outside, double inside, double radius) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (outside + inside);
    (profile.IsInside(middle, radius) ? inside : outside) = middle;
  }
  return inside;
}

std::optional<std::vector<double>> Sample(const Profile& profile, double z_min, double z_max,
                                          int count) {
  std::vector<double> values(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const auto g = profile.At(z_min + (z_max - z_min) * i / (count - 1));
    if (!g || !std::isfinite(*g)) return {};
    values[static_cast<std::size_t>(i)] = *g;
  }
  return values;
}

/// Error of straight lines between every other value, at the values left out [px].
double ErrorOfHalf(const std::vector<double>& values, double z_min, double z_max, double scale) {
  const double step = (z_max - z_min) / static_cast<double>(values.size() - 1);
  double worst = 0.0;
  for (std::size_t i = 1; i + 1 < values.size(); i += 2) {
    const double z = z_min + static_cast<double>(i) * step;
    const double rho = std::sqrt(std::max(0.0, (1.0 - z) * (1.0 + z)));
    const double line = 0.5 * (values[i - 1] + values[i + 1]);
    worst = std::max(worst, scale * rho * std::abs(line - values[i]));
  }
  return worst;
}

}  // namespace

RadialProjection::RadialProjection(const RadialProjection& other)
    : knots_(other.knots_),
      table_(other.table_),
      R_optical_camera_(other.R_optical_camera_),
      table_error_px_(other.table_error_px_) {
  table_.knots = knots_.data();
}

RadialProjection& RadialProjection::operator=(const RadialProjection& other) {
  RadialProjection copy(other);
  *this = std::move(copy);
  return *this;
}

std::optional<RadialProjection> RadialProjection::Create(const CameraModel& camera) {
  const auto symmetry = camera.Symmetry();
  if (!symmetry || !(symmetry->z_max > std::max(symmetry->z_min, kLeastZ))) return {};
  const Profile profile(camera, *symmetry);
  const double radius = profile.CornerRadius();
  double z_min = std::max(symmetry->z_min, kLeastZ);
  double z_max = symmetry->z_max;
  const bool low_inside = profile.IsInside(z_min, radius);
  const bool high_inside = profile.IsInside(z_max, radius);
  if (!low_inside && !high_inside) return {};
  if (!low_inside) z_min = Narrowed(profile, z_min, z_max, radius);
  if (!high_inside) z_max = Narrowed(profile, z_max, z_min, radius);

  // Sampled twice as finely as it is kept, so that the error is known.
  const double scale = symmetry->affine.colwise().norm().maxCoeff();
  RadialProjection made;
  for (int intervals = kLeastKnots; intervals < kMaxKnots; intervals *= 2) {
    const auto fine = Sample(profile, z_min, z_max, 2 * intervals + 1);
    if (!fine) return {};
    made.table_error_px_ = ErrorOfHalf(*fine, z_min, z_max, scale);
    made.knots_.clear();
    for (std::size_t i = 0; i < fine->size(); i += 2) {
      made.knots_.push_back(static_cast<float>((*fine)[i]));
    }
    if (made.table_error_px_ <= kTableTolerancePx) break;
  }

  RadialTable& t = made.table_;
  t.knots = made.knots_.data();
  t.count = static_cast<int>(made.knots_.size());
  t.z_min = static_cast<float>(z_min);
  t.z_max = static_cast<float>(z_max);
  t.inverse_step = static_cast<float>((t.count - 1) / (z_max - z_min));
  t.center_u_px = static_cast<float>(symmetry->center_px.x());
  t.center_v_px = static_cast<float>(symmetry->center_px.y());
  for (int i = 0; i < 4; ++i) t.affine[i] = static_cast<float>(symmetry->affine(i / 2, i % 2));
  t.width_px = camera.width_px();
  t.height_px = camera.height_px();
  made.R_optical_camera_ = symmetry->R_optical_camera;
  return made;
}

}  // namespace kawara::vision
