#pragma once
#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/config/constraints.hpp"
#include "core/expected.hpp"
#include "vision/camera/camera_choice.hpp"

namespace kawara::vision {

/// The models whose numbers can be looked for.
enum class CalibrationModel {
  kDoughnut,           ///< the paper's eq. (2): elevation linear in the radius
  kDoughnutCorrected,  ///< with an odd polynomial's k1..k3
  kOcam,               ///< a0, a2, a3, a4
  kMei,                ///< xi, k1, k2
  kDoubleSphere,
  kEucm,
  kKannalaBrandt
};

constexpr auto ConfigNames(CalibrationModel) {
  using core::config::EnumName;
  using enum CalibrationModel;
  return std::array{EnumName<CalibrationModel>{kDoughnut, "doughnut"},
                    EnumName<CalibrationModel>{kDoughnutCorrected, "doughnut-corrected"},
                    EnumName<CalibrationModel>{kOcam, "ocam"},
                    EnumName<CalibrationModel>{kMei, "mei"},
                    EnumName<CalibrationModel>{kDoubleSphere, "ds"},
                    EnumName<CalibrationModel>{kEucm, "eucm"},
                    EnumName<CalibrationModel>{kKannalaBrandt, "kb"}};
}
std::string NameOf(CalibrationModel model);

/// What is known of a camera beforehand. Boards cannot tell the last two: they are flat, and turn
/// with the camera.
struct CalibrationPicture {
  int width_px = 0;
  int height_px = 0;
  bool mirrored = false;                ///< as CameraChoice's models say it
  OpticalAxis axis = OpticalAxis::kUp;  ///< of a doughnut up or down
};

/// A number that is looked for.
struct TrialParameter {
  const char* name;       ///< as camera.yaml calls it
  double low, high;       ///< of the parameter
  double step;            ///< changes the picture by about a hundred millionth of its size
  double per_unit = 1.0;  ///< the file's number for a parameter of 1
};

/// A camera with any numbers, cheap to make and not asking whether they make sense: the formulas of
/// vision/camera over rays of the OPTICAL frame, up to any angle. All models are
///   pixel = centre + affine * (x, y) / rho * radius(rho, z).
class TrialCamera {
 public:
  /// `parameters`: as many as ParametersOf() lists, in its order.
  TrialCamera(CalibrationModel model, const CalibrationPicture& picture,
              const Eigen::VectorXd& parameters);

  static std::vector<TrialParameter> ParametersOf(CalibrationModel model,
                                                  const CalibrationPicture& picture);

  /// Pixel of a ray of any length; not finite where the formula has no value. `by_ray`: its
  /// derivative, if wanted.
  Eigen::Vector2d Project(const Eigen::Vector3d& ray_optical,
                          Eigen::Matrix<double, 2, 3>* by_ray = nullptr) const;
  /// In the plane before `affine`; not finite where there is none.
  double Radius(double angle_rad) const;
  const Eigen::Matrix2d& affine() const { return affine_; }
  const Eigen::Vector2d& center_px() const { return center_px_; }
  /// Of a pixel: distance from the centre in the plane before `affine`.
  double PlaneRadius(const Eigen::Vector2d& pixel_px) const;

 private:
  CalibrationModel model_;
  Eigen::Vector2d center_px_;
  Eigen::Matrix2d affine_;
  std::shared_ptr<const RadialLaw> law_;  ///< null: a doughnut
  double l_base_px_ = 0.0, px_per_unit_ = 0.0, horizon_ = 0.0;
  OddPolynomial correction_;
};

/// Angles from the optical axis that a calibration is good for [rad].
struct AngleRange {
  double low_rad = 0.0;
  double high_rad = 0.0;
};

/// The same camera as camera.yaml writes it, seeing `seen`: a doughnut's circles, a lens's
/// max_angle_deg (from the axis outwards). kInvalidArgument: vision/camera refuses the numbers.
core::Expected<CameraChoice> ChoiceOf(CalibrationModel model, const CalibrationPicture& picture,
                                      const Eigen::VectorXd& parameters, const AngleRange& seen);

}  // namespace kawara::vision
