#pragma once
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/changed_object.hpp"
#include "core/geodesy.hpp"
#include "vision/change/reference_builder.hpp"
#include "vision/change/road_area.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision::test_support {

/// A straight road of 40 x 8 m along the x axis at height 0 between two walls at y = +-6, as points
/// with noise, seen from a way along y = -1.5.
class Street {
 public:
  explicit Street(std::uint32_t seed = 1, double noise_m = 0.03) : dice_(seed), noise_m_(noise_m) {}

  static RoadArea Road() {
    return *RoadArea::Make({{"road", {{-20, -4}, {20, -4}, {20, 4}, {-20, 4}}, {}}});
  }
  void AddGround() {
    for (double x = -20; x <= 20; x += 0.08)
      for (double y = -6; y <= 6; y += 0.08) Add({x, y, 0.0}, {0, 0, 1});
  }
  void AddWalls() {
    for (const double y : {-6.0, 6.0})
      for (double x = -20; x <= 20; x += 0.08)
        for (double z = 0; z <= 5; z += 0.08) Add({x, y, z}, {0, y > 0 ? -1.0 : 1.0, 0});
  }
  /// The sides of a box; under it the ground is not seen.
  void AddBox(const core::UprightBox& box) {
    std::erase_if(surfaces_, [&](const Surface& s) {
      const Eigen::Vector2d off = (s.at - box.centre_m).head<2>();
      return std::abs(s.at.z()) < 0.2 && std::abs(off.dot(box.Forward())) < box.size_m.x() / 2 &&
             std::abs(off.dot(box.Left())) < box.size_m.y() / 2;
    });
    const Eigen::Vector2d f = box.Forward(), l = box.Left();
    const auto side = [&](const Eigen::Vector2d& out, double reach, const Eigen::Vector2d& along,
                          double half) {
      for (double a = -half; a <= half; a += 0.06)
        for (double z = 0; z <= box.size_m.z(); z += 0.06) {
          const Eigen::Vector2d at = box.centre_m.head<2>() + reach * out + a * along;
          Add({at.x(), at.y(), box.centre_m.z() - box.size_m.z() / 2 + z}, {out.x(), out.y(), 0});
        }
    };
    side(f, box.size_m.x() / 2, l, box.size_m.y() / 2);
    side(-f, box.size_m.x() / 2, l, box.size_m.y() / 2);
    side(l, box.size_m.y() / 2, f, box.size_m.x() / 2);
    side(-l, box.size_m.y() / 2, f, box.size_m.x() / 2);
  }

  /// What the way's viewers see of it all, in voxels of 20 cm.
  VoxelMap Look() const {
    auto map = *VoxelMap::Create({.voxel_m = 0.2});
    for (double x = -20; x <= 20; x += 2.0) EXPECT_TRUE(map.Vote(VotesFrom(Eye(x))));
    return map;
  }
  static Eigen::Vector3d Eye(double x) { return {x, -1.5, 1.6}; }
  std::vector<PointVote> VotesFrom(const Eigen::Vector3d& eye) const {
    std::vector<PointVote> votes;
    for (const Surface& s : surfaces_) {
      const Eigen::Vector3d look = eye - s.at;
      if (look.norm() > 9.0 || look.dot(s.normal) < 0.1 * look.norm()) continue;
      PointVote vote;
      vote.position_m = s.at;
      vote.to_viewer = look.normalized().cast<float>();
      vote.sd_m = static_cast<float>(noise_m_);
      votes.push_back(vote);
    }
    return votes;
  }
  std::vector<Eigen::Vector3d> Points() const {
    std::vector<Eigen::Vector3d> points;
    for (const Surface& s : surfaces_) points.push_back(s.at);
    return points;
  }
  /// The same as the reference knows it.
  ReferenceMap Reference() const {
    ReferenceBuilder builder;
    builder.Begin({"street", "laser", core::UtcTime::FromNs(1), 0.02});
    builder.AddPoints(Points());
    return builder.Finish(true);
  }

 private:
  struct Surface {
    Eigen::Vector3d at, normal;
  };
  void Add(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    surfaces_.push_back({p + noise_m_ * normal_(dice_) * normal, normal});
  }
  std::mt19937 dice_;
  std::normal_distribution<double> normal_;
  double noise_m_;
  std::vector<Surface> surfaces_;
};

inline core::UprightBox Truck(double x, double y, double heading_deg = 90.0) {
  return {{x, y, 1.5}, {7.0, 2.2, 3.0}, heading_deg * core::kRadFromDeg};
}
inline core::UprightBox Car(double x, double y, double heading_deg = 90.0) {
  return {{x, y, 0.75}, {4.4, 1.7, 1.5}, heading_deg * core::kRadFromDeg};
}

}  // namespace kawara::vision::test_support
