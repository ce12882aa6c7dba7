#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "sim/render/lit_scene.hpp"
#include "sim/render/ray_scene.hpp"
#include "sim/site/site_config.hpp"
#include "sim/site/terrain.hpp"
#include "vision/change/reference_map.hpp"
#include "vision/change/road_area.hpp"
#include "vision/stereo/range_image.hpp"
#include "vision/voxel/camera_rays.hpp"

/// Drives past made streets for the third update's benchmark: true distances of the simulator's
/// scenes, spoiled as stereo spoils them.
namespace kawara::change_bench {

/// How distances and poses err.
struct Errors {
  double sd_per_m2 = 0.00767;   ///< of a range, times its square: the paper's 151 mm over 2-6 m
  double outliers = 0.03;       ///< share of pixels with a range of somewhere else
  double shared = 0.0;          ///< share of 8 x 8 blocks of pixels whose error is one
  double outlier_blocks = 0.0;  ///< share of such blocks that are elsewhere altogether
  double missing = 0.0;         ///< share of pixels without a range
  double position_sd_m = 0.03;  ///< drawn anew every 20 pictures
  double up_sd_m = 0.05;
  double heading_sd_rad = 0.00175;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< of all poses: east, north, up
  double offset_heading_rad = 0.0;
  static Errors Hard();
};

struct Picture {
  vision::RangeImage ranges;
  Eigen::Isometry3d map_from_camera;  ///< as measured
};

/// What truly changed.
struct TrueObject {
  std::string name;
  core::UprightBox box;
};

/// A site with the vehicles put a little elsewhere by a seed, and the robot's way past them.
class ChangeDrive {
 public:
  struct Options {
    std::string site;  ///< file
    std::uint64_t seed = 1;
    int pictures = 200;
    int columns = 1024;
    double from_m = -38.0, to_m = 22.0;  ///< east, along the road
    bool vehicles = true;                ///< false: nothing has changed
  };
  explicit ChangeDrive(const Options& options);

  /// Distance image of picture `i`, the same at every call; different draws by `draw`.
  Picture Take(int i, const Errors& errors, std::uint64_t draw) const;
  /// Points of two laser scanners on the road before, with `sd_m`.
  std::vector<Eigen::Vector3d> LaserPoints(int scans, double sd_m) const;
  vision::ReferenceMap Reference() const;
  vision::RoadArea Road() const;

  const vision::CameraRays& rays() const { return *rays_; }
  std::shared_ptr<const vision::CameraModel> camera() const { return camera_; }
  /// Of what stands there now.
  core::Expected<std::shared_ptr<const sim::LitScene>> Lit() const;
  const std::vector<TrueObject>& truth() const { return truth_; }
  const sim::Terrain& terrain() const { return *terrain_; }
  int pictures() const { return options_.pictures; }
  Eigen::Isometry3d TruePose(int i) const;
  /// True surface of what changed: nearest distance from a point to it [m], by the boxes' meshes.
  double DistanceToChange(const Eigen::Vector3d& p) const;
  /// What of the changed surfaces could be seen from the way, within 8 m.
  const std::vector<Eigen::Vector3d>& change_samples() const { return change_samples_; }

 private:
  Eigen::Isometry3d PoseAt(double east_m) const;
  vision::RangeImage Cast(const sim::RayScene& scene, const Eigen::Isometry3d& pose) const;

  Options options_;
  sim::SiteConfig site_;
  std::unique_ptr<sim::Terrain> terrain_;
  std::unique_ptr<sim::RayScene> before_, after_;
  std::shared_ptr<const vision::CameraModel> camera_;
  std::unique_ptr<vision::CameraRays> rays_;
  std::vector<TrueObject> truth_;
  std::vector<Eigen::Vector3d> change_samples_;
};

}  // namespace kawara::change_bench
