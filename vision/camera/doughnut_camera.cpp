#include "vision/camera/doughnut_camera.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kawara::vision {
namespace {

using core::ErrorCode;
using core::Fail;

// Rounding may put a point of the rim this far outside it [px]; it still counts as the rim.
constexpr double kRimTolerancePx = 1e-9;
// What phi_top and phi_bottom may differ from eq. (2) at the circles; more is a mistake, not
// calibration noise.
constexpr double kCircleToleranceDeg = 1.0;
// Of P(a): flatter is about to fold.
constexpr double kLeastSlope = 1e-2;

template <class... Parts>
tl::unexpected<core::Error> Refuse(const Parts&... parts) {
  std::ostringstream text;
  text << "doughnut camera: ";
  (text << ... << parts);
  return Fail(ErrorCode::kInvalidArgument, text.str());
}

}  // namespace

// Pixel centres are at integers, so the picture's corner, which scaling keeps, is at -0.5.
DoughnutParameters DoughnutParameters::Scaled(int eighths) const {
  const double scale = eighths / 8.0;
  DoughnutParameters r = *this;
  r.width_px = (width_px * eighths + 7) / 8;
  r.height_px = (height_px * eighths + 7) / 8;
  r.center_u_px = (center_u_px + 0.5) * scale - 0.5;
  r.center_v_px = (center_v_px + 0.5) * scale - 0.5;
  r.l_in_px = l_in_px * scale;
  r.l_base_px = l_base_px * scale;
  r.l_out_px = l_out_px * scale;
  return r;
}

DoughnutParameters DoughnutParameters::Resized(int new_width_px, int new_height_px) const {
  const double scale_u = static_cast<double>(new_width_px) / width_px;
  const double scale_v = static_cast<double>(new_height_px) / height_px;
  DoughnutParameters r = *this;
  r.width_px = new_width_px;
  r.height_px = new_height_px;
  r.center_u_px = (center_u_px + 0.5) * scale_u - 0.5;
  r.center_v_px = (center_v_px + 0.5) * scale_v - 0.5;
  r.l_in_px = l_in_px * scale_u;
  r.l_base_px = l_base_px * scale_u;
  r.l_out_px = l_out_px * scale_u;
  r.v_scale = v_scale * scale_v / scale_u;
  return r;
}

core::Expected<DoughnutCamera> DoughnutCamera::Create(const DoughnutParameters& p) {
  for (double value : {p.center_u_px, p.center_v_px, p.l_in_px, p.l_base_px, p.l_out_px,
                       p.phi_top_deg, p.phi_bottom_deg, p.forward_deg, p.v_scale, p.correction[0],
                       p.correction[1], p.correction[2], p.correction[3]}) {
    if (!std::isfinite(value)) return Refuse("a parameter is not a finite number");
  }
  if (p.width_px < 2 || p.height_px < 2) {
    return Refuse("picture of ", p.width_px, " x ", p.height_px, " px: expected at least 2 x 2");
  }
  if (p.l_in_px < 0.0 || p.l_out_px <= p.l_in_px) {
    return Refuse("l_in_px = ", p.l_in_px, ", l_out_px = ", p.l_out_px,
                  ": expected 0 <= l_in_px < l_out_px");
  }
  if (p.v_scale < 0.1 || p.v_scale > 10.0)
    return Refuse("v_scale = ", p.v_scale, ": expected 0.1..10");
  const double deg_per_px = (p.phi_top_deg - p.phi_bottom_deg) / (p.l_out_px - p.l_in_px);
  if (std::abs(deg_per_px) < 1e-6) {
    return Refuse("phi_top_deg = phi_bottom_deg = ", p.phi_top_deg, ": expected two elevations");
  }
  const double side = p.phi_top_deg > p.phi_bottom_deg ? 1.0 : -1.0;
  const OddPolynomial correction{p.correction};
  for (double share = 0.0; share <= 1.0; share += 1.0 / 256.0) {
    const double phi_deg = p.phi_top_deg + share * (p.phi_bottom_deg - p.phi_top_deg);
    if (!(correction.Slope((90.0 - side * phi_deg) * core::kRadFromDeg) > kLeastSlope)) {
      return Refuse("correction: the radius does not grow steadily from the inner circle to the ",
                    "outer one");
    }
  }
  const DoughnutCamera made(p);
  const double inner_deg = made.ElevationAt(p.l_in_px) * core::kDegFromRad;
  const double outer_deg = made.ElevationAt(p.l_out_px) * core::kDegFromRad;
  if (std::abs(inner_deg - p.phi_top_deg) > kCircleToleranceDeg) {
    return Refuse("l_base_px = ", p.l_base_px, " puts ", inner_deg,
                  " deg on the inner circle, phi_top_deg says ", p.phi_top_deg, "; l_base_px = ",
                  p.l_in_px + p.l_base_px - made.RadiusOf(p.phi_top_deg * core::kRadFromDeg),
                  " would fit");
  }
  // A circle may lie past the axis by what fitting noise makes of it, not more.
  if (std::max(std::abs(inner_deg), std::abs(outer_deg)) > 90.0 + kCircleToleranceDeg) {
    return Refuse("elevations ", outer_deg, " to ", inner_deg, " deg: expected within +-90");
  }
  return made;
}

DoughnutCamera::DoughnutCamera(const DoughnutParameters& parameters)
    : p_(parameters),
      correction_{parameters.correction},
      side_(p_.phi_top_deg > p_.phi_bottom_deg ? 1.0 : -1.0),
      rad_per_px_((p_.phi_top_deg - p_.phi_bottom_deg) * core::kRadFromDeg /
                  (p_.l_out_px - p_.l_in_px)),
      cos_forward_(std::cos(p_.forward_deg * core::kRadFromDeg)),
      sin_forward_(std::sin(p_.forward_deg * core::kRadFromDeg)) {
  const auto unit = [this](double phi_deg) {
    return correction_.Value((90.0 - side_ * phi_deg) * core::kRadFromDeg);
  };
  px_per_unit_ = (p_.l_out_px - p_.l_in_px) / (unit(p_.phi_bottom_deg) - unit(p_.phi_top_deg));
}

double DoughnutCamera::RadiusOf(double phi_rad) const {
  if (correction_.IsIdentity()) return p_.l_base_px - phi_rad / rad_per_px_;  // eq. (2), for r
  const double horizon = correction_.Value(core::kPi / 2);
  return p_.l_base_px +
         px_per_unit_ * (correction_.Value(core::kPi / 2 - side_ * phi_rad) - horizon);
}

double DoughnutCamera::ElevationAt(double r_px) const {
  if (correction_.IsIdentity()) return rad_per_px_ * (p_.l_base_px - r_px);
  // Known to grow between the circles; what the tolerance of the circles adds goes on so.
  const double horizon = correction_.Value(core::kPi / 2);
  const double inner = core::kPi / 2 - side_ * p_.phi_top_deg * core::kRadFromDeg;
  const double outer = core::kPi / 2 - side_ * p_.phi_bottom_deg * core::kRadFromDeg;
  const double slack = 2.0 * kCircleToleranceDeg * core::kRadFromDeg;
  const double a = correction_.Solve(horizon + (r_px - p_.l_base_px) / px_per_unit_, inner - slack,
                                     outer + slack);
  return side_ * (core::kPi / 2 - a);
}

std::optional<Eigen::Vector2d> DoughnutCamera::Project(const Eigen::Vector3d& ray_camera) const {
  const double horizontal = std::hypot(ray_camera.y(), ray_camera.z());
  const double phi_rad = std::atan2(ray_camera.x(), horizontal);
  const double r_px = RadiusOf(phi_rad);
  if (!(r_px >= p_.l_in_px - kRimTolerancePx && r_px <= p_.l_out_px + kRimTolerancePx)) return {};
  if (horizontal == 0.0) {
    if (r_px > kRimTolerancePx) return {};  // the axis itself: no direction in the picture
    return Eigen::Vector2d(p_.center_u_px, p_.center_v_px);
  }
  // Eq. (1) backwards, without angles: (cos theta, sin theta) turned by the forward direction.
  const double c = ray_camera.z() / horizontal;
  const double s = (p_.mirrored ? -ray_camera.y() : ray_camera.y()) / horizontal;
  return Eigen::Vector2d(
      p_.center_u_px + r_px * (c * cos_forward_ - s * sin_forward_),
      p_.center_v_px + p_.v_scale * r_px * (s * cos_forward_ + c * sin_forward_));
}

std::optional<Eigen::Vector3d> DoughnutCamera::Unproject(const Eigen::Vector2d& pixel_px) const {
  const double u = pixel_px.x() - p_.center_u_px;
  const double v = (pixel_px.y() - p_.center_v_px) / p_.v_scale;
  const double r_px = std::hypot(u, v);
  if (!(r_px >= p_.l_in_px - kRimTolerancePx && r_px <= p_.l_out_px + kRimTolerancePx)) return {};
  const double phi_rad = ElevationAt(r_px);
  const double inverse_r = r_px > 0.0 ? 1.0 / r_px : 0.0;
  const double c = (u * cos_forward_ + v * sin_forward_) * inverse_r;
  const double s = (v * cos_forward_ - u * sin_forward_) * inverse_r;
  return Eigen::Vector3d(std::sin(phi_rad), std::cos(phi_rad) * (p_.mirrored ? -s : s),
                         std::cos(phi_rad) * c);
}

// With the optical frame of OpticalAxis::kUp, x = -Y, y = -Z and z = X = sin phi, so that Project's
// c * horizontal = -y and s * horizontal = -x, or x if mirrored.
std::optional<RadialSymmetry> DoughnutCamera::Symmetry() const {
  RadialSymmetry symmetry;
  symmetry.R_optical_camera = CameraFromOptical(OpticalAxis::kUp).transpose();
  symmetry.center_px = {p_.center_u_px, p_.center_v_px};
  const double hand = p_.mirrored ? 1.0 : -1.0;
  symmetry.affine << -hand * sin_forward_, -cos_forward_, p_.v_scale * hand * cos_forward_,
      -p_.v_scale * sin_forward_;
  const ElevationRange seen = Elevations();
  symmetry.z_min = std::sin(std::max(seen.bottom_rad, -core::kPi / 2));
  symmetry.z_max = std::sin(std::min(seen.top_rad, core::kPi / 2));
  return symmetry;
}

ElevationRange DoughnutCamera::Elevations() const {
  const double inner_rad = ElevationAt(p_.l_in_px);
  const double outer_rad = ElevationAt(p_.l_out_px);
  return {std::min(inner_rad, outer_rad), std::max(inner_rad, outer_rad)};
}

}  // namespace kawara::vision
