#pragma once
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/render/lit_scene.hpp"
#include "sim/site/scene_builder.hpp"
#include "sim/site/site_config.hpp"
#include "sim/vehicle/simulate_drive.hpp"

namespace kawara::sim {

/// Which world: a site file, a robot file, and what chance makes of them.
struct SiteWorldOptions {
  std::filesystem::path site;    ///< configs/sites/*.yaml
  std::filesystem::path robot;   ///< configs/vehicles/*.yaml
  std::vector<std::string> set;  ///< "dotted.key=value" over the site file
  std::uint64_t seed = 1;        ///< of the drive: sensors, wheels; the site has its own
  bool lit = true;               ///< cameras look at it; without light it is made much faster
  LightSettings light;
  core::GpsTime begin;  ///< of the mission: when the vehicle begins to stand
};

/// A site after the disaster, with a vehicle that has driven through it: geometry, light, the
/// motion, and what the sensors measured on the way. The same options give the same world, byte for
/// byte. Not changed after Create(); any thread reads it.
class SiteWorld {
 public:
  /// Takes some seconds. Errors: the two files (every mistake with its line), a path that cannot be
  /// driven.
  static core::Expected<std::unique_ptr<const SiteWorld>> Create(const SiteWorldOptions& options);

  const SiteConfig& site() const { return site_; }
  const RobotModel& robot() const { return robot_; }
  const Terrain& terrain() const { return *terrain_; }
  const Scene& scene() const { return scene_; }  ///< after the disaster
  /// Null if the world was asked for without light.
  const std::shared_ptr<const LitScene>& lit() const { return lit_; }
  const RayScene& rays() const { return lit_ ? lit_->rays() : *rays_; }
  const Recording& recording() const { return drive_->recording; }
  const DriveTruth& truth() const { return drive_->truth; }
  const Trajectory& trajectory() const { return drive_->truth.trajectory; }

  /// The camera stands upright on the body and looks ahead.
  Eigen::Isometry3d EnuFromCamera(core::GpsTime t) const;
  /// A scanner's pose as RangeScanner wants it: x to its right, y ahead, z up.
  Eigen::Isometry3d EnuFromScanner(const ScannerMount& mount, core::GpsTime t) const;
  /// Seconds of the mission: which things stand at the site.
  double MissionSeconds(core::GpsTime t) const;

 private:
  SiteWorld() = default;
  SiteConfig site_;
  RobotModel robot_;
  std::unique_ptr<const Terrain> terrain_;
  Scene scene_;
  std::shared_ptr<const LitScene> lit_;
  std::unique_ptr<const RayScene> rays_;  ///< null if lit_ has them
  std::unique_ptr<const SimulatedDrive> drive_;
};

}  // namespace kawara::sim
