#pragma once
#include <Eigen/Core>
#include <vector>

#include "vision/image.hpp"
#include "vision/stereo/rectified_picture.hpp"
#include "vision/stereo/stereo_camera.hpp"

namespace kawara::vision {

/// Brings pictures onto epipolar grids. Every pair has its own epipoles, so there is no table to
/// keep; the camera's radial table makes the projection cheap. Keeps its memory; one thread at a
/// time.
class Rectifier {
 public:
  /// `camera_from_epipolar`: epipolar_pair.hpp. Bilinear; the picture is of the camera's size.
  void Rectify(const StereoCamera& camera, const ConstImageView& picture,
               const Eigen::Matrix3d& camera_from_epipolar, const EpipolarGrid& grid,
               RectifiedPicture& rectified);

 private:
  void ProjectEach(const StereoCamera& camera, const Eigen::Matrix3d& camera_from_epipolar,
                   double beta_rad);

  std::vector<std::uint32_t> source_;
  std::vector<float> cosine_, sine_, u_px_, v_px_;
};

}  // namespace kawara::vision
