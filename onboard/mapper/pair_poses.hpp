#pragma once
#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "onboard/survey/survey.hpp"
#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/stereo_camera.hpp"

namespace kawara::mapper {

/// Where two frames' cameras were.
struct PairPoses {
  Eigen::Isometry3d map_from_a = Eigen::Isometry3d::Identity();  ///< camera frames
  Eigen::Isometry3d map_from_b = Eigen::Isometry3d::Identity();
  vision::StepDoubt doubt;
  int frames_used = 0;  ///< by the refinement, the two among them; 0: as the survey says
  /// How far B moved against A from where the survey says it is.
  double step_change_m = 0.0, step_change_rad = 0.0;
  std::string warning;  ///< one line, or empty
};

/// As the survey says; the doubt is that of its deviations, white, if it states any.
PairPoses GivenPairPoses(const survey::Survey& survey, const survey::SurveyFrame& a,
                         const survey::SurveyFrame& b);

/// Refined on the pictures (vision/refine) of the drive about the two frames, five metres or ten
/// steps of it; of cameras at one moment as GivenPairPoses. `cameras`: one of each of the survey's;
/// those of the two frames must be there. Errors: of loading pictures.
core::Expected<PairPoses> RefinePairPoses(
    const survey::Survey& survey, const survey::SurveyFrame& a, const survey::SurveyFrame& b,
    const std::vector<std::shared_ptr<const vision::StereoCamera>>& cameras);

}  // namespace kawara::mapper
