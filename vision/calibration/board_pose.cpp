#include "vision/calibration/board_pose.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>

namespace kawara::vision {

// ray x (H (x, y, 1)) = 0 with H = [r1 r2 t]: two equations a point, the smallest eigenvector.
std::optional<Eigen::Isometry3d> PoseFromRays(std::span<const Eigen::Vector2d> on_plane_m,
                                              std::span<const Eigen::Vector3d> rays) {
  if (rays.size() < 4 || on_plane_m.size() != rays.size()) return {};
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& point : on_plane_m) middle += point;
  middle /= static_cast<double>(on_plane_m.size());
  double size = 0.0;
  for (const auto& point : on_plane_m) size += (point - middle).norm();
  size /= static_cast<double>(on_plane_m.size());
  if (!(size > 0.0)) return {};
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  Matrix9d normal = Matrix9d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector2d q = (on_plane_m[i] - middle) / size;
    const Eigen::Vector3d plane(q.x(), q.y(), 1.0);
    const Eigen::Vector3d ray = rays[i].normalized();
    // (I - ray ray') H plane = 0; H column by column.
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) normal.block<3, 3>(3 * a, 3 * b) += plane[a] * plane[b] * across;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Matrix9d> solver(normal);
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Eigen::Matrix3d H = Eigen::Map<const Eigen::Matrix3d>(h.data());
  double ahead = 0.0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector2d q = (on_plane_m[i] - middle) / size;
    ahead += rays[i].dot(H * Eigen::Vector3d(q.x(), q.y(), 1.0));
  }
  if (ahead < 0.0) H = -H;
  const double scale = std::sqrt(H.col(0).norm() * H.col(1).norm());
  if (!(scale > 1e-9)) return {};
  H /= scale;
  Eigen::Matrix3d R;
  R << H.col(0), H.col(1), H.col(0).cross(H.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[2] > 1e-6)) return {};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = svd.matrixU() * svd.matrixV().transpose();
  if (pose.linear().determinant() < 0.0) return {};
  pose.translation() =
      size * H.col(2) - pose.linear() * Eigen::Vector3d(middle.x(), middle.y(), 0.0);
  return pose;
}

}  // namespace kawara::vision
