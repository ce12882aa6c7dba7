#include "vision/voxel/camera_rays.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geodesy.hpp"

namespace kawara::vision {
namespace {

// 6 faces of 768^2 are 14 MB: beyond that a nearest pixel is good enough for a camera that fine.
constexpr std::size_t kMinFacePx = 64;
constexpr std::size_t kMaxFacePx = 768;

}  // namespace

CameraRays::CameraRays(const CameraModel& camera) : CameraRays(camera, RayTables()) {}

CameraRays::CameraRays(const CameraModel& camera, const RayTables& rays)
    : width_px_(camera.width_px()), height_px_(camera.height_px()), rays_(rays) {
  if (rays.x == nullptr) MakeRays(camera);
  face_px_ = ChooseFace();
  half_face_ = 0.5F * static_cast<float>(face_px_);
  FillFaces(camera);
}

void CameraRays::MakeRays(const CameraModel& camera) {
  for (auto* table : {&own_x_, &own_y_, &own_z_})
    table->assign(pixels(), std::numeric_limits<float>::quiet_NaN());
  std::size_t i = 0;
  for (int v = 0; v < height_px_; ++v) {
    for (int u = 0; u < width_px_; ++u, ++i) {
      const auto ray = camera.Unproject({u, v});
      if (!ray) continue;
      const Eigen::Vector3f r = ray->normalized().cast<float>();
      own_x_[i] = r.x();
      own_y_[i] = r.y();
      own_z_[i] = r.z();
    }
  }
  rays_ = {own_x_.data(), own_y_.data(), own_z_.data()};
}

// Texels at the middle of a face, where they are widest seen from the centre, as fine as the finest
// pixels.
std::size_t CameraRays::ChooseFace() const {
  constexpr int kStep = 7;
  float smallest_rad = 1.0F;
  for (int v = 0; v < height_px_; v += kStep) {
    for (int u = 0; u + 1 < width_px_; u += kStep) {
      const auto i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px_) +
                     static_cast<std::size_t>(u);
      const float step_rad = (ray(i + 1) - ray(i)).norm();
      if (step_rad > 1e-5F && step_rad < smallest_rad) smallest_rad = step_rad;
    }
  }
  return std::clamp(static_cast<std::size_t>(2.0F / smallest_rad), kMinFacePx, kMaxFacePx);
}

void CameraRays::FillFaces(const CameraModel& camera) {
  nearest_.assign(6 * face_px_ * face_px_, kNoPixel);
  const double texel_size = 2.0 / static_cast<double>(face_px_);
  std::size_t texel = 0;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const auto [u_axis, v_axis] = kOtherAxes[static_cast<std::size_t>(axis)];
    Eigen::Vector3d direction;
    direction[axis] = face % 2 == 0 ? 1.0 : -1.0;
    for (std::size_t row = 0; row < face_px_; ++row) {
      direction[v_axis] = (static_cast<double>(row) + 0.5) * texel_size - 1.0;
      for (std::size_t column = 0; column < face_px_; ++column, ++texel) {
        direction[u_axis] = (static_cast<double>(column) + 0.5) * texel_size - 1.0;
        const auto at = camera.Project(direction);
        if (!at) continue;
        const double u = std::round(at->x()), v = std::round(at->y());
        if (!(u >= 0.0 && u < width_px_ && v >= 0.0 && v < height_px_)) continue;
        const auto pixel = static_cast<std::int32_t>(v) * width_px_ + static_cast<std::int32_t>(u);
        if (!std::isnan(rays_.x[pixel])) nearest_[texel] = pixel;
      }
    }
  }
}

float CameraRays::PixelsPerSteradian(std::int32_t pixel) const {
  const int u = pixel % width_px_, v = pixel / width_px_;
  // Half the way from the one neighbour to the other, or to the one there is.
  const auto step = [&](int du, int dv) -> Eigen::Vector3f {
    const auto there = [&](int sign) -> Eigen::Vector3f {
      const int uu = u + sign * du, vv = v + sign * dv;
      if (uu < 0 || uu >= width_px_ || vv < 0 || vv >= height_px_)
        return Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
      return ray(static_cast<std::size_t>(vv) * static_cast<std::size_t>(width_px_) +
                 static_cast<std::size_t>(uu));
    };
    const Eigen::Vector3f here = ray(static_cast<std::size_t>(pixel));
    const Eigen::Vector3f next = there(1), last = there(-1);
    if (next.hasNaN() && last.hasNaN()) return Eigen::Vector3f::Zero();
    if (next.hasNaN()) return here - last;
    if (last.hasNaN()) return next - here;
    return 0.5F * (next - last);
  };
  const float solid_angle_sr = step(1, 0).cross(step(0, 1)).norm();
  return solid_angle_sr > 0.0F ? 1.0F / solid_angle_sr : 0.0F;
}

}  // namespace kawara::vision
