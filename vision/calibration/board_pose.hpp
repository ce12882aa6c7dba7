#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <span>

namespace kawara::vision {

/// Where a plane lies whose points are seen along rays: takes the plane's (x, y, 0) [m] to the
/// frame of the rays. Rays may point anywhere, behind the camera as well. Linear, good enough to
/// begin an adjustment with. Empty: fewer than 4 points, all on a line, or rays that no plane fits.
std::optional<Eigen::Isometry3d> PoseFromRays(std::span<const Eigen::Vector2d> on_plane_m,
                                              std::span<const Eigen::Vector3d> rays);

}  // namespace kawara::vision
