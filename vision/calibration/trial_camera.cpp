#include "vision/calibration/trial_camera.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "vision/camera/radial_laws.hpp"

namespace kawara::vision {
namespace {

/// Radius to which an OCam's coefficients are scaled, so that all are of the size of a0.
double OcamUnit(const CalibrationPicture& picture) {
  return 0.5 * std::min(picture.width_px, picture.height_px);
}

std::vector<double> OcamPolynomial(const CalibrationPicture& picture, const Eigen::VectorXd& p) {
  const double unit = OcamUnit(picture);
  return {p[4], 0.0, p[5] / unit, p[6] / (unit * unit), p[7] / (unit * unit * unit)};
}

bool IsDoughnut(CalibrationModel model) {
  return model == CalibrationModel::kDoughnut || model == CalibrationModel::kDoughnutCorrected;
}

/// Radius of a doughnut's law over the angle from the axis of its inner side.
OddPolynomial CorrectionOf(CalibrationModel model, const Eigen::VectorXd& p) {
  if (model == CalibrationModel::kDoughnut) return {};
  return {{p[5], p[6], p[7], 0.0}};
}

}  // namespace

std::string NameOf(CalibrationModel model) {
  for (const auto& name : ConfigNames(model)) {
    if (name.value == model) return std::string(name.name);
  }
  return "?";
}

std::vector<TrialParameter> TrialCamera::ParametersOf(CalibrationModel model,
                                                      const CalibrationPicture& picture) {
  const double u = picture.width_px, v = picture.height_px, far = 20.0 * std::max(u, v);
  std::vector<TrialParameter> all{{"center_u_px", -u, 2 * u, 1e-4},
                                  {"center_v_px", -v, 2 * v, 1e-4}};
  const auto add = [&all](std::initializer_list<TrialParameter> more) {
    all.insert(all.end(), more);
  };
  constexpr double kFree = 1e3;  // of coefficients: no bound that would be met
  if (IsDoughnut(model)) {
    add({{"v_scale", 0.2, 5.0, 1e-7},
         {"l_base_px", -far, far, 1e-4},
         {"px_per_rad", 1, far, 1e-4}});
    if (model == CalibrationModel::kDoughnutCorrected) {
      add({{"k1", -kFree, kFree, 1e-8}, {"k2", -kFree, kFree, 1e-8}, {"k3", -kFree, kFree, 1e-8}});
    }
    return all;
  }
  if (model == CalibrationModel::kOcam) {
    const double unit = OcamUnit(picture);
    add({{"affine_c", 0.2, 5.0, 1e-7},
         {"affine_d", -1.0, 1.0, 1e-7},
         {"a0", 1.0, far, 1e-4},
         {"a2", -far, far, 1e-4, 1.0 / unit},
         {"a3", -far, far, 1e-4, 1.0 / (unit * unit)},
         {"a4", -far, far, 1e-4, 1.0 / (unit * unit * unit)}});
    return all;
  }
  add({{"fx_px", 1.0, far, 1e-4}, {"fy_px", 1.0, far, 1e-4}});
  switch (model) {
    case CalibrationModel::kMei:
      add({{"xi", 0.0, 50.0, 1e-7}, {"k1", -kFree, kFree, 1e-8}, {"k2", -kFree, kFree, 1e-8}});
      break;
    case CalibrationModel::kDoubleSphere:
      add({{"xi", -0.99, 1.0, 1e-7}, {"alpha", 0.0, 1.0, 1e-7}});
      break;
    case CalibrationModel::kEucm:
      add({{"alpha", 0.0, 1.0, 1e-7}, {"beta", 1e-3, kFree, 1e-7}});
      break;
    default:
      add({{"k1", -kFree, kFree, 1e-8},
           {"k2", -kFree, kFree, 1e-8},
           {"k3", -kFree, kFree, 1e-8},
           {"k4", -kFree, kFree, 1e-8}});
  }
  return all;
}

TrialCamera::TrialCamera(CalibrationModel model, const CalibrationPicture& picture,
                         const Eigen::VectorXd& p)
    : model_(model), center_px_(p[0], p[1]) {
  // Radius() is asked beyond the domain as well: looking for its end would take most of the time.
  constexpr double kNoDomain = 1e-3;
  if (IsDoughnut(model)) {
    // DoughnutCamera's, forward_deg = 0, in the frame of OpticalAxis::kUp or kDown.
    const bool down = picture.axis == OpticalAxis::kDown;
    const double hand = picture.mirrored == down ? -1.0 : 1.0;
    affine_ << 0.0, -1.0, hand * p[2], 0.0;
    l_base_px_ = p[3];
    px_per_unit_ = p[4];
    correction_ = CorrectionOf(model, p);
    horizon_ = correction_.Value(core::kPi / 2);
    return;
  }
  if (model == CalibrationModel::kOcam) {
    affine_ << 1.0, 0.0, p[3], p[2];
  } else {
    affine_ << p[2], 0.0, 0.0, p[3];
  }
  if (picture.mirrored) affine_.col(0) *= -1.0;
  switch (model) {
    case CalibrationModel::kOcam:
      law_ = std::make_shared<OcamLaw>(OcamPolynomial(picture, p), kNoDomain);
      break;
    case CalibrationModel::kMei:
      law_ = std::make_shared<UnifiedLaw>(p[4], OddPolynomial{{p[5], p[6], 0.0, 0.0}}, kNoDomain);
      break;
    case CalibrationModel::kDoubleSphere:
      law_ = std::make_shared<DoubleSphereLaw>(p[4], p[5], kNoDomain);
      break;
    case CalibrationModel::kEucm:
      law_ = std::make_shared<ExtendedUnifiedLaw>(p[4], p[5], kNoDomain);
      break;
    default:
      law_ = std::make_shared<KannalaBrandtLaw>(OddPolynomial{{p[4], p[5], p[6], p[7]}}, kNoDomain);
  }
}

double TrialCamera::Radius(double angle_rad) const {
  if (law_ == nullptr) {
    return l_base_px_ + px_per_unit_ * (correction_.Value(angle_rad) - horizon_);
  }
  return law_->Radius({std::sin(angle_rad), std::cos(angle_rad)});
}

Eigen::Vector2d TrialCamera::Project(const Eigen::Vector3d& ray,
                                     Eigen::Matrix<double, 2, 3>* by_ray) const {
  const double rho = std::max(1e-12, std::hypot(ray.x(), ray.y()));
  const double length_squared = rho * rho + ray.z() * ray.z();
  const double angle = std::atan2(rho, ray.z());
  const double radius = Radius(angle);
  const Eigen::Vector2d across = ray.head<2>() / rho;
  if (by_ray != nullptr) {
    constexpr double kStep = 1e-6;
    const double slope = (Radius(angle + kStep) - Radius(angle - kStep)) / (2.0 * kStep);
    const Eigen::Matrix2d turn = Eigen::Matrix2d::Identity() - across * across.transpose();
    by_ray->leftCols<2>() = affine_ * (radius / rho * turn + slope * ray.z() / length_squared *
                                                                 across * across.transpose());
    by_ray->col(2) = affine_ * across * (-slope * rho / length_squared);
  }
  return center_px_ + affine_ * across * radius;
}

double TrialCamera::PlaneRadius(const Eigen::Vector2d& pixel_px) const {
  return (affine_.inverse() * (pixel_px - center_px_)).norm();
}

core::Expected<CameraChoice> ChoiceOf(CalibrationModel model, const CalibrationPicture& picture,
                                      const Eigen::VectorXd& p, const AngleRange& seen) {
  CameraChoice choice;
  const TrialCamera trial(model, picture, p);
  const auto set_common = [&](LensCommon& common) {
    common.width_px = picture.width_px;
    common.height_px = picture.height_px;
    common.center_u_px = p[0];
    common.center_v_px = p[1];
    common.mirrored = picture.mirrored;
    common.axis = picture.axis;
    common.max_angle_deg = std::min(180.0, seen.high_rad * core::kDegFromRad);
  };
  const auto set_lens = [&](auto& lens) {
    set_common(lens.common);
    lens.focal.fx_px = p[2];
    lens.focal.fy_px = p[3];
  };
  switch (model) {
    case CalibrationModel::kDoughnut:
    case CalibrationModel::kDoughnutCorrected: {
      if (picture.axis == OpticalAxis::kForward) {
        return core::Fail(core::ErrorCode::kInvalidArgument,
                          "a doughnut's axis is up or down, not forward");
      }
      choice.camera = "doughnut";
      DoughnutParameters& ring = choice.doughnut;
      ring.width_px = picture.width_px;
      ring.height_px = picture.height_px;
      ring.center_u_px = p[0];
      ring.center_v_px = p[1];
      ring.v_scale = p[2];
      ring.l_base_px = p[3];
      ring.correction = CorrectionOf(model, p).k;
      ring.mirrored = picture.mirrored;
      // A ring: straight along the axis there is no direction.
      const double low = std::clamp(seen.low_rad, 0.0, core::kPi);
      const double high = std::clamp(seen.high_rad, 0.0, core::kPi);
      ring.l_in_px = std::max(0.0, trial.Radius(low));
      ring.l_out_px = trial.Radius(high);
      const double side = picture.axis == OpticalAxis::kDown ? -1.0 : 1.0;
      ring.phi_top_deg = side * (90.0 - low * core::kDegFromRad);
      ring.phi_bottom_deg = side * (90.0 - high * core::kDegFromRad);
      break;
    }
    case CalibrationModel::kOcam:
      choice.camera = "ocam";
      set_common(choice.ocam.common);
      choice.ocam.polynomial = OcamPolynomial(picture, p);
      choice.ocam.affine_c = p[2];
      choice.ocam.affine_d = p[3];
      choice.ocam.affine_e = 0.0;
      break;
    case CalibrationModel::kMei:
      choice.camera = "mei";
      set_lens(choice.mei);
      choice.mei.xi = p[4];
      choice.mei.k1 = p[5];
      choice.mei.k2 = p[6];
      break;
    case CalibrationModel::kDoubleSphere:
      choice.camera = "double_sphere";
      set_lens(choice.double_sphere);
      choice.double_sphere.xi = p[4];
      choice.double_sphere.alpha = p[5];
      break;
    case CalibrationModel::kEucm:
      choice.camera = "eucm";
      set_lens(choice.eucm);
      choice.eucm.alpha = p[4];
      choice.eucm.beta = p[5];
      break;
    case CalibrationModel::kKannalaBrandt:
      choice.camera = "kb4";
      set_lens(choice.kb4);
      for (std::size_t i = 0; i < 4; ++i) choice.kb4.k[i] = p[4 + static_cast<Eigen::Index>(i)];
      break;
  }
  const auto camera = MakeCamera(choice);
  if (!camera) return tl::unexpected(camera.error());
  return choice;
}

}  // namespace kawara::vision
