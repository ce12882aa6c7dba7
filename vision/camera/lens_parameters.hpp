#pragma once
#include <array>
#include <vector>

#include "core/config/constraints.hpp"
#include "core/expected.hpp"
#include "vision/camera/lens_camera.hpp"

/// The lens models as lines of a file. Numbers are those of the common calibration programs; pixel
/// (0, 0) is the CENTRE of the first pixel, as everywhere here.
namespace kawara::vision {

/// What every lens has.
struct LensCommon {
  int width_px = 0;
  int height_px = 0;
  double center_u_px = 0.0;
  double center_v_px = 0.0;
  bool mirrored = false;
  OpticalAxis axis = OpticalAxis::kForward;
  double max_angle_deg = 180.0;  ///< from the optical axis; what is beyond is not used

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("width_px", width_px, Range{2, 65500});
    v("height_px", height_px, Range{2, 65500});
    v("center_u_px", center_u_px, Range{-65500, 131000});
    v("center_v_px", center_v_px, Range{-65500, 131000});
    v("mirrored", mirrored, Optional{});
    v("axis", axis, Optional{});
    v("max_angle_deg", max_angle_deg, Range{1, 180}, Optional{});
  }
};

struct LensFocal {
  double fx_px = 0.0;
  double fy_px = 0.0;
  double skew_px = 0.0;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("fx_px", fx_px, Range{0.1, 1e6});
    v("fy_px", fy_px, Range{0.1, 1e6});
    v("skew_px", skew_px, Range{-1e6, 1e6}, Optional{});
  }
};

/// KannalaBrandtLaw; without k the equidistant lens.
struct KannalaBrandtParameters {
  LensCommon common;
  LensFocal focal;
  std::array<double, 4> k{};

  template <class V>
  void Visit(V& v) {
    common.Visit(v);
    focal.Visit(v);
    v("k", k, core::config::Optional{});
  }
};

/// OcamLaw, as calib_results.txt: v = c x' + d y' + centre, u = e x' + y' + centre with x' down and
/// y' to the right.
struct OcamParameters {
  LensCommon common;
  std::vector<double> polynomial;  ///< a0, a1, a2 ... [px]
  double affine_c = 1.0;
  double affine_d = 0.0;
  double affine_e = 0.0;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    common.Visit(v);
    v("polynomial", polynomial, core::config::NotEmpty{});
    v("affine_c", affine_c, Range{0.1, 10}, Optional{});
    v("affine_d", affine_d, Range{-1, 1}, Optional{});
    v("affine_e", affine_e, Range{-1, 1}, Optional{});
  }
};

/// UnifiedLaw, or TangentialLaw if p1 or p2 is not zero.
struct MeiParameters {
  LensCommon common;
  LensFocal focal;
  double xi = 1.0;
  double k1 = 0.0, k2 = 0.0, k3 = 0.0;
  double p1 = 0.0, p2 = 0.0;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    common.Visit(v);
    focal.Visit(v);
    v("xi", xi, core::config::Range{0, 100});
    v("k1", k1, Optional{});
    v("k2", k2, Optional{});
    v("k3", k3, Optional{});
    v("p1", p1, Optional{});
    v("p2", p2, Optional{});
  }
};

struct EucmParameters {
  LensCommon common;
  LensFocal focal;
  double alpha = 0.5;
  double beta = 1.0;

  template <class V>
  void Visit(V& v) {
    common.Visit(v);
    focal.Visit(v);
    v("alpha", alpha, core::config::Range{0, 1});
    v("beta", beta, core::config::Range{1e-3, 1e3});
  }
};

struct DoubleSphereParameters {
  LensCommon common;
  LensFocal focal;
  double xi = 0.0;
  double alpha = 0.5;

  template <class V>
  void Visit(V& v) {
    common.Visit(v);
    focal.Visit(v);
    v("xi", xi, core::config::Range{-0.999, 1});
    v("alpha", alpha, core::config::Range{0, 1});
  }
};

/// kInvalidArgument: numbers that make no lens, with the reason.
core::Expected<LensCamera> MakeLens(const KannalaBrandtParameters& parameters);
core::Expected<LensCamera> MakeLens(const OcamParameters& parameters);
core::Expected<LensCamera> MakeLens(const MeiParameters& parameters);
core::Expected<LensCamera> MakeLens(const EucmParameters& parameters);
core::Expected<LensCamera> MakeLens(const DoubleSphereParameters& parameters);

}  // namespace kawara::vision
