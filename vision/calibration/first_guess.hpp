#pragma once
#include <optional>
#include <vector>

#include "vision/calibration/bundle.hpp"

namespace kawara::vision {

/// A rough camera and where the boards were, from nothing but the views: radii linear in the angle,
/// tried over centres, scales and offsets, by how well the boards come out flat; the best few are
/// adjusted as CalibrationModel::kDoughnutCorrected, which bends to any mirror or fisheye. Empty:
/// no camera makes boards of these views. The frame is the optical one whatever `picture.axis`.
std::optional<BundleState> GuessCamera(const CalibrationPicture& picture, double square_m,
                                       const std::vector<BoardView>& views);

/// The numbers of `model` that come nearest to what a camera of `from` does over the angles `seen`:
/// radii of the model fitted to its radii. Several where the fit has several minima (a double
/// sphere's with either sign of xi), the nearest first: which one it is only the boards can tell.
/// Empty: the model cannot do that.
std::vector<Eigen::VectorXd> ConvertCamera(CalibrationModel from, const Eigen::VectorXd& numbers,
                                           CalibrationModel model,
                                           const CalibrationPicture& picture,
                                           const AngleRange& seen);

/// Angles from the optical axis at which a camera sees the corners.
AngleRange SeenAngles(const BundleProblem& problem, const BundleState& state);

}  // namespace kawara::vision
