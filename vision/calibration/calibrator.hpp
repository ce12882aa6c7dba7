#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "vision/calibration/bundle.hpp"
#include "vision/calibration/coverage.hpp"

namespace kawara::vision {

struct CalibrationOptions {
  CalibrationPicture picture;
  double square_m = 0.03;
  /// The picture's circles [px], where they are known; else the calibration is said to be good for
  /// what boards reached, and a twentieth more on either side.
  std::optional<double> inner_px, outer_px;
  /// The picture's rim, found in the pictures: what coverage is measured against only.
  std::optional<double> rim_px;
};

/// A number of the camera, as camera.yaml has it.
struct EstimatedNumber {
  std::string name;
  double value = 0.0;
  double sd = 0.0;
};

struct CameraCalibration {
  CalibrationModel model = CalibrationModel::kOcam;
  CameraChoice optics;
  std::vector<EstimatedNumber> numbers;
  BundleFit fit;
  AngleRange seen;  ///< that `optics` is good for
  Coverage coverage;
  /// Deviation of where the camera projects a direction, the largest over what boards covered, by
  /// the covariance of the numbers [px].
  double projection_sd_px = 0.0;
  /// Of pictures the numbers were not fitted to, in turn: root of the mean square distance [px].
  double cross_validated_px = 0.0;
  int left_out = 0;  ///< corners that contradict the rest
  std::vector<std::string> warnings;
};

/// A camera's numbers from views of a board. kInvalidArgument, with the reason: too few views,
/// boards that do not determine a camera (all parallel, all in one place), no camera of the model
/// that explains them. One call works for itself; any thread.
class Calibrator {
 public:
  /// `views` of at least 12 corners each.
  static core::Expected<Calibrator> Create(const CalibrationOptions& options,
                                           std::vector<BoardView> views);

  core::Expected<CameraCalibration> Calibrate(CalibrationModel model) const;
  /// All models by cross validation; the one with the fewest numbers of those that are as good as
  /// the best, first. Models that cannot explain the views are left out.
  core::Expected<std::vector<CameraCalibration>> CalibrateAll() const;

  const std::vector<BoardView>& views() const { return views_; }

 private:
  Calibrator(const CalibrationOptions& options, std::vector<BoardView> views)
      : options_(options), views_(std::move(views)) {}
  BundleProblem ProblemOf(CalibrationModel model) const;
  std::vector<BundleState> StartsOf(CalibrationModel model) const;
  double CrossValidated(const BundleProblem& problem, const BundleFit& fit) const;
  void Judge(CameraCalibration& made) const;

  CalibrationOptions options_;
  std::vector<BoardView> views_;
  BundleState guess_;  ///< as kDoughnutCorrected
};

}  // namespace kawara::vision
