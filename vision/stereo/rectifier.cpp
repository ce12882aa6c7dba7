#include "vision/stereo/rectifier.hpp"

#include <cmath>
#include <limits>

#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/rectify_kernel.hpp"

namespace kawara::vision {

void Rectifier::ProjectEach(const StereoCamera& camera, const Eigen::Matrix3d& camera_from_epipolar,
                            double beta_rad) {
  const Eigen::Vector3d side = camera_from_epipolar * EpipolarPair::Ray(core::kPi / 2, beta_rad);
  for (std::size_t x = 0; x < cosine_.size(); ++x) {
    const Eigen::Vector3d ray = static_cast<double>(cosine_[x]) * camera_from_epipolar.col(0) +
                                static_cast<double>(sine_[x]) * side;
    const auto pixel = camera.model().Project(ray);
    u_px_[x] = pixel ? static_cast<float>(pixel->x()) : std::numeric_limits<float>::quiet_NaN();
    v_px_[x] = pixel ? static_cast<float>(pixel->y()) : std::numeric_limits<float>::quiet_NaN();
  }
}

void Rectifier::Rectify(const StereoCamera& camera, const ConstImageView& picture,
                        const Eigen::Matrix3d& camera_from_epipolar, const EpipolarGrid& grid,
                        RectifiedPicture& rectified) {
  const auto width = static_cast<std::size_t>(grid.width_px);
  camera.rays().Pack(picture, source_);
  rectified.Resize(grid);
  for (auto* row : {&cosine_, &sine_, &u_px_, &v_px_}) row->resize(width);
  for (std::size_t x = 0; x < width; ++x) {
    cosine_[x] = static_cast<float>(std::cos(grid.alpha_rad(static_cast<double>(x))));
    sine_[x] = static_cast<float>(std::sin(grid.alpha_rad(static_cast<double>(x))));
  }
  for (int y = 0; y < grid.height_px; ++y) {
    const double beta_rad = grid.beta_rad(y);
    if (camera.projection()) {
      const Eigen::Matrix3d R = camera.projection()->R_optical_camera() * camera_from_epipolar;
      const Eigen::Vector3d side = R * EpipolarPair::Ray(core::kPi / 2, beta_rad);
      rectify::Meridian meridian{};
      for (int k = 0; k < 3; ++k) {
        meridian.pole[k] = static_cast<float>(R(k, 0));
        meridian.side[k] = static_cast<float>(side(k));
      }
      rectify::ProjectRow(camera.projection()->table(), meridian, cosine_.data(), sine_.data(),
                          width, u_px_.data(), v_px_.data());
    } else {
      ProjectEach(camera, camera_from_epipolar, beta_rad);
    }
    rectify::SampleRow(source_.data(), picture.width_px, picture.height_px, u_px_.data(),
                       v_px_.data(), width, rectified.row(y));
  }
}

}  // namespace kawara::vision
