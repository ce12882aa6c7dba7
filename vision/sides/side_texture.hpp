#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/object_textures.hpp"
#include "core/time.hpp"
#include "vision/jpeg.hpp"
#include "vision/model/texture.hpp"

namespace kawara::vision {

/// A picture that may show an object. Owns no pixels.
struct SideView {
  TextureView view;
  /// [height][width] of the picture: 0 hides a pixel (the robot's own body). Empty: none is.
  std::span<const std::uint8_t> mask = {};
  std::string source = {};  ///< name of the picture: "mission/epoch"
  core::UtcTime taken = {};
};

struct SideTextureConfig {
  double texel_m = 0.02;    ///< aimed at; coarser if the atlas grew too large
  int max_atlas_px = 1024;  ///< of a side, 64 or more
  int jpeg_quality = 85;
  double min_incidence_cos = 0.1;  ///< flatter looks are not used
  /// Nearer by this (and three deviations of the range and of the side's place) hides a side: what
  /// stands out of a box is no obstacle.
  double depth_margin_m = 0.15;
  /// A side of which less is seen gets no picture.
  double min_seen_share = 0.05;
};

/// Pictures of an object's sides, rectified, in one small atlas: of the sides that were seen
/// (side_seen) and of the top if any picture shows it. Every side is taken from the view that shows
/// it best: by incidence, pixels a texel, sharpness beside the other views, and how much of it is
/// in the picture, not masked and not hidden behind what the distance image shows nearer. What it
/// does not show, or shows less than half as well, comes from the next best ones, brought to its
/// exposure and blended at the seams; what nobody shows has the side's mean colour and is not in
/// seen_share. A face's source and time are those of the view that shows most of it.
/// Nothing seen: empty textures. The same input gives the same bytes. Any thread with its own
/// encoder.
/// Errors: kInvalidArgument (a box without volume or not finite; sizes of picture, mask, distance
/// image and camera that differ; settings out of range), those of the JPEG encoder.
core::Expected<core::ObjectTextures> MakeSideTextures(const core::ChangedObject& object,
                                                      std::span<const SideView> views,
                                                      const SideTextureConfig& config,
                                                      JpegEncoder& encoder);

}  // namespace kawara::vision
