#pragma once
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "tests/bench/changes/change_drive.hpp"
#include "vision/change/change_finder.hpp"

namespace kawara::change_bench {

/// A side's texture beside the simulator's own look at it.
struct JudgedSide {
  std::string uid;
  core::BoxSide side = core::BoxSide::kFront;
  double seen_share = 0.0;
  double correlation = 0.0;  ///< of the brightness, as the texture lies
  double aligned = 0.0;      ///< of the brightness, shifted to where it fits best
  double off_px = 0.0;       ///< that shift, whole texels
  double texel_m = 0.0;
  double make_s = 0.0;    ///< CPU, for the object
  double atlas_kb = 0.0;  ///< of the object
};

/// Textures of what was found, from the drive's own pictures 2 m apart: rendered where the robot
/// truly was, laid on where it believes it was, with the distances it measured. The truth is the
/// same scene rendered through the found side's frame from 3 m before its middle, without noise and
/// dirt. `folder`: for the atlases and truths as PNG; empty: nowhere.
core::Expected<std::vector<JudgedSide>> JudgeTextures(const ChangeDrive& drive,
                                                      const Errors& errors, std::uint64_t draw,
                                                      const vision::Findings& found,
                                                      const std::string& folder);

}  // namespace kawara::change_bench
