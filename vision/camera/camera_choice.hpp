#pragma once
#include <memory>
#include <string>

#include "core/config/constraints.hpp"
#include "core/expected.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/camera/lens_parameters.hpp"

namespace kawara::vision {

/// PanoramaGeometry as lines of a file; of a picture of the full sphere only its size is needed.
struct EquirectangularParameters {
  int width_px = 2048;
  int height_px = 1024;
  int full_width_px = 0;   ///< 0: as wide as the picture
  int full_height_px = 0;  ///< 0: half the full width
  int left_px = 0;
  int top_px = -1;  ///< -1: the middle row is the horizon

  PanoramaGeometry Geometry() const;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("width_px", width_px, Range{2, 65500});
    v("height_px", height_px, Range{1, 65500});
    v("full_width_px", full_width_px, Range{0, 65500}, Optional{});
    v("full_height_px", full_height_px, Range{0, 65500}, Optional{});
    v("left_px", left_px, Range{0, 65500}, Optional{});
    v("top_px", top_px, Range{-1, 65500}, Optional{});
  }
};

/// Which camera, of all the models there are: `camera` names one, the section of the same name
/// holds its numbers. Doughnut and equirectangular have the keys of the robot's configuration under
/// `picture`.
struct CameraChoice {
  std::string camera = "doughnut";
  DoughnutParameters doughnut;
  EquirectangularParameters equirectangular;
  KannalaBrandtParameters equidistant;  ///< kb4 with k = 0
  KannalaBrandtParameters kb4;
  OcamParameters ocam;
  MeiParameters mei;
  EucmParameters eucm;
  DoubleSphereParameters double_sphere;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    v("camera", camera, Names());
    VisitSections([&](const char* key, auto& section) { v(key, section, Optional{}); });
  }

  static core::config::OneOf Names() {
    return {"doughnut", "equirectangular", "equidistant", "kb4", "ocam", "mei",
            "eucm",     "double_sphere"};
  }
  static CameraChoice Of(const DoughnutParameters& parameters) {
    CameraChoice choice;
    choice.doughnut = parameters;
    return choice;
  }

  /// `visit(name, section)` for every model.
  template <class F>
  void VisitSections(F&& visit) {
    visit("doughnut", doughnut);
    visit("equirectangular", equirectangular);
    visit("equidistant", equidistant);
    visit("kb4", kb4);
    visit("ocam", ocam);
    visit("mei", mei);
    visit("eucm", eucm);
    visit("double_sphere", double_sphere);
  }
};

/// kInvalidArgument: what the model refuses.
core::Expected<std::shared_ptr<const CameraModel>> MakeCamera(const CameraChoice& choice);

}  // namespace kawara::vision
