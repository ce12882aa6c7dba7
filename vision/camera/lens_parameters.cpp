#include "vision/camera/lens_parameters.hpp"

#include <cmath>
#include <memory>

#include "vision/camera/radial_laws.hpp"
#include "vision/camera/tangential_law.hpp"

namespace kawara::vision {
namespace {

LensPicture PictureOf(const LensCommon& common) {
  LensPicture picture;
  picture.width_px = common.width_px;
  picture.height_px = common.height_px;
  picture.center_px = {common.center_u_px, common.center_v_px};
  picture.mirrored = common.mirrored;
  picture.axis = common.axis;
  return picture;
}

LensPicture PictureOf(const LensCommon& common, const LensFocal& focal) {
  LensPicture picture = PictureOf(common);
  picture.affine << focal.fx_px, focal.skew_px, 0.0, focal.fy_px;
  return picture;
}

double MaxAngle(const LensCommon& common) { return common.max_angle_deg * core::kRadFromDeg; }

core::Expected<LensCamera> Refuse(const std::string& what) {
  return core::Fail(core::ErrorCode::kInvalidArgument, "lens camera: " + what);
}

// Configuration files are checked before they come here; values from anywhere else are not.
bool AllFinite(std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

}  // namespace

core::Expected<LensCamera> MakeLens(const KannalaBrandtParameters& p) {
  if (!AllFinite({p.k[0], p.k[1], p.k[2], p.k[3], p.common.max_angle_deg})) {
    return Refuse("k: expected four finite numbers");
  }
  return LensCamera::Create(
      std::make_shared<KannalaBrandtLaw>(OddPolynomial{p.k}, MaxAngle(p.common)),
      PictureOf(p.common, p.focal));
}

core::Expected<LensCamera> MakeLens(const OcamParameters& p) {
  if (p.polynomial.empty() || p.polynomial.size() > 32 || p.polynomial[0] == 0.0) {
    return Refuse("polynomial: expected 1 to 32 coefficients, the first not 0");
  }
  for (const double a : p.polynomial) {
    if (!AllFinite({a, p.common.max_angle_deg})) {
      return Refuse("polynomial: expected finite numbers");
    }
  }
  LensPicture picture = PictureOf(p.common);
  picture.affine << 1.0, p.affine_e, p.affine_d, p.affine_c;
  return LensCamera::Create(std::make_shared<OcamLaw>(p.polynomial, MaxAngle(p.common)), picture);
}

core::Expected<LensCamera> MakeLens(const MeiParameters& p) {
  if (!AllFinite({p.xi, p.k1, p.k2, p.k3, p.p1, p.p2, p.common.max_angle_deg}) || p.xi < 0.0) {
    return Refuse("xi, k1, k2, k3, p1, p2: expected finite numbers, xi not negative");
  }
  const UnifiedLaw radial(p.xi, OddPolynomial{{p.k1, p.k2, p.k3, 0.0}}, MaxAngle(p.common));
  std::shared_ptr<const LensLaw> law;
  if (p.p1 == 0.0 && p.p2 == 0.0) {
    law = std::make_shared<UnifiedLaw>(radial);
  } else {
    law = std::make_shared<TangentialLaw>(radial, p.p1, p.p2);
  }
  return LensCamera::Create(std::move(law), PictureOf(p.common, p.focal));
}

core::Expected<LensCamera> MakeLens(const EucmParameters& p) {
  if (!(p.alpha >= 0.0 && p.alpha <= 1.0 && p.beta > 0.0 && p.beta <= 1e6)) {
    return Refuse("alpha, beta: expected 0 <= alpha <= 1 and beta > 0");
  }
  return LensCamera::Create(
      std::make_shared<ExtendedUnifiedLaw>(p.alpha, p.beta, MaxAngle(p.common)),
      PictureOf(p.common, p.focal));
}

core::Expected<LensCamera> MakeLens(const DoubleSphereParameters& p) {
  if (!(p.alpha >= 0.0 && p.alpha <= 1.0 && p.xi > -1.0 && p.xi <= 1.0)) {
    return Refuse("xi, alpha: expected -1 < xi <= 1 and 0 <= alpha <= 1");
  }
  return LensCamera::Create(std::make_shared<DoubleSphereLaw>(p.xi, p.alpha, MaxAngle(p.common)),
                            PictureOf(p.common, p.focal));
}

}  // namespace kawara::vision
