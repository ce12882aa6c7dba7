#pragma once
#include <filesystem>
#include <string>

#include "core/expected.hpp"
#include "onboard/mapper/range_files.hpp"
#include "onboard/mapper/stereo_method.hpp"
#include "onboard/survey/survey.hpp"

namespace kawara::mapper {

/// What `kawara-mapper SURVEY --depth-only A B` is asked for.
struct DepthOptions {
  std::filesystem::path survey;
  std::string frame_a, frame_b;
  std::filesystem::path out = ".";
  StereoOptions stereo;
  bool find_nearest =
      true;            ///< of stereo.nearest_m nothing is taken: as near as there is something
  bool refine = true;  ///< poses on the pictures about the two; false: as the survey says
};

struct DepthResult {
  RangeFiles files;
  double baseline_m = 0.0;
  int frames_used = 0;  ///< by the refinement of the poses; 0: they are the survey's
  double step_change_m = 0.0, step_change_rad = 0.0;  ///< by it, of B against A
  double known = 0.0;                                 ///< part of the pixels the camera sees
  double median_range_m = 0.0;
  double median_sd_m = 0.0;
  double seconds = 0.0;  ///< of the matching alone
  std::string warning;   ///< one line, or empty
};

/// A frame by its name: the picture's file name with or without its ending, or the end of its path
/// ("frames/00007.jpg"), with several cameras also "CAMERA/NAME". Errors: kNotFound (says what
/// names there are), kInvalidArgument (several fit).
core::Expected<const survey::SurveyFrame*> FindFrame(const survey::Survey& survey,
                                                     const std::string& name);

/// The distance image of frame A by stereo with frame B. Errors: the survey's; kInvalidArgument:
/// the frames are the same place; kFormat: the pictures have nothing in common.
core::Expected<DepthResult> RunDepthOnly(const DepthOptions& options);

}  // namespace kawara::mapper
