#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "vision/calibration/board.hpp"
#include "vision/calibration/trial_camera.hpp"

namespace kawara::vision {

/// What a bundle adjustment of boards finds.
struct BundleState {
  Eigen::VectorXd parameters;                         ///< TrialCamera's
  std::vector<Eigen::Isometry3d> optical_from_board;  ///< a view
};

struct BundleProblem {
  CalibrationModel model = CalibrationModel::kOcam;
  CalibrationPicture picture;
  double square_m = 0.03;
  const std::vector<BoardView>* views = nullptr;
  /// Parameters that keep their values, by index; empty: none.
  std::vector<bool> fixed;
};

struct BundleFit {
  BundleState state;
  /// Seen less computed, a view, a corner [px].
  std::vector<std::vector<Eigen::Vector2d>> residuals;
  /// Corners that contradict the rest are not used.
  std::vector<std::vector<bool>> used;
  /// Root of the mean square distance of the corners used [px], both directions together.
  double rms_px = 0.0;
  /// Of one coordinate of a corner, by what is left and the degrees of freedom [px].
  double sd_px = 0.0;
  /// Of the parameters, the poses being free; fixed ones have rows of zeros.
  Eigen::MatrixXd covariance;
  /// False: the numbers are not determined by these views (a singular problem).
  bool determined = false;
  int iterations = 0;
};

/// Levenberg and Marquardt over the camera's numbers and a pose a view; poses are eliminated view
/// by view. Corners are weighed down by Cauchy's law at first, those beyond five deviations then
/// left out for good, and the rest counts in full. Reentrant.
BundleFit FitBundle(const BundleProblem& problem, const BundleState& start);

/// The same with the camera's numbers fixed and one view: what a camera makes of a view it was not
/// fitted to. Root of the mean square distance [px]; not finite: no pose fits.
double ViewRms(const BundleProblem& problem, const Eigen::VectorXd& parameters,
               const BoardView& view, const Eigen::Isometry3d& start);

}  // namespace kawara::vision
