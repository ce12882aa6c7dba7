#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <span>

#include "core/expected.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"
#include "vision/jpeg.hpp"
#include "vision/model/surface.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::vision {

/// A picture to take a texture from. Owns nothing.
struct TextureView {
  const CameraModel& camera;
  ConstImageView picture;  ///< of that camera
  /// Tells what hides what, with or without sd: of the picture's size, or RangesForTexture of that.
  /// Null: nobody knows.
  const RangeImage* ranges = nullptr;
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
};

/// kInvalidArgument: picture, distance image and camera differ in size, or the pose is not finite.
core::Expected<void> CheckView(const TextureView& view);

/// An eighth of the memory and still enough to tell what hides what: every second pixel of every
/// second row from the first, sizes rounded up, without deviations.
RangeImage RangesForTexture(const RangeImage& ranges);

struct TextureConfig {
  double texel_m = 0.02;    ///< aimed at; coarser if the atlas grew too large
  int max_atlas_px = 4096;  ///< of a side
  int jpeg_quality = 85;
  double min_incidence_cos = 0.1;  ///< flatter looks are not used
};

struct TextureCounts {
  std::size_t quads = 0;
  std::size_t from_pictures = 0;  ///< the others have the colours of their voxels
};

/// Gives a surface a texture: every quad becomes a small square of one atlas, taken from the
/// picture that shows it best (pixels an area: cosine of incidence / distance^2; not hidden behind
/// what the picture's distance image shows nearer; rather the one its neighbour has). Pictures of
/// other exposure are brought to the colours of the voxels, which are means over all. Corners are
/// then four for each quad. Errors: kInvalidArgument (sizes differ), those of the JPEG encoder; the
/// surface is left as it was.
core::Expected<TextureCounts> ApplyTexture(Surface& surface, double voxel_m,
                                           std::span<const TextureView> views,
                                           const TextureConfig& config, JpegEncoder& encoder);

}  // namespace kawara::vision
