#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/expected.hpp"
#include "sim/world/rendered_pictures.hpp"
#include "sim/world/site_world.hpp"
#include "vision/camera/camera_choice.hpp"

namespace kawara::sim {

/// A drive rendered to a folder, for work without time.
struct SurveyOptions {
  std::filesystem::path folder;
  vision::CameraChoice optics;
  RenderedCameraOptions camera;
  double every_m = 0.5;              ///< between exposures, along the way
  double start_s = 0.0;              ///< of the mission
  std::optional<double> duration_s;  ///< none: to the end
  double pose_noise_m = 0.02;        ///< standard deviation a frame and axis, white
  double attitude_noise_deg = 0.1;
  std::uint64_t noise_seed = 1;  ///< of the poses' noise
};

struct SurveySummary {
  int frames = 0;
  double way_m = 0.0;
  double seconds_a_frame = 0.0;
};

/// Renders and writes (numbers count from 00001):
///   frames/N.jpg, range/N.png (mm, 16 bits: 0 outside, 65535 sky), object/N.png (ids)
///   poses.csv           frame,gps_ns,lat_deg,... of the CAMERA's viewpoint with the chosen noise,
///   and
///                       the noise's standard deviations
///   truth_frames.csv    the same without noise
///   truth.lcm           objects, poses and exposures (see TruthRecorder)
///   camera.yaml         the optics (vision/camera/camera_choice.hpp)
/// and the files of WriteWorldTruth. Prints a line every few seconds. `stop` ends it after the
/// frame it is at; what is written is whole. Errors: kIo.
core::Expected<SurveySummary> RenderSurvey(const SiteWorld& world, const SurveyOptions& options,
                                           const std::atomic<bool>& stop);

}  // namespace kawara::sim
