#include "sim/world/site_world.hpp"

#include "core/config/config.hpp"
#include "vision/camera/camera_model.hpp"

namespace kawara::sim {
namespace {

/// Farther up no wall reaches.
constexpr double kSkyRange_m = 500.0;
/// Downward moment of a vehicle's iron on the northern half of the Earth, by its footprint.
constexpr double kMomentPerSquareMetre_am2 = 12.0;

PathConfig PathOf(const RouteConfig& route) {
  PathConfig path;
  path.speed_mps = route.speed_mps;
  for (const auto& point : route.points) {
    path.waypoints.push_back({point.at_m[0], point.at_m[1], point.speed_mps, 0.0});
  }
  return path;
}

std::vector<SteelObject> SteelOf(const Scene& scene) {
  std::vector<SteelObject> steel;
  for (const SceneObject& object : scene.objects) {
    if (object.cls != ObjectClass::kCar && object.cls != ObjectClass::kTruck) continue;
    const double moment_am2 =
        kMomentPerSquareMetre_am2 * object.box.size_m.x() * object.box.size_m.y();
    steel.push_back({object.box.centre_enu_m, {0.0, 0.0, -moment_am2}});
  }
  return steel;
}

}  // namespace

core::Expected<std::unique_ptr<const SiteWorld>> SiteWorld::Create(
    const SiteWorldOptions& options) {
  auto site = LoadSite(options.site.string(), options.set);
  if (!site) return tl::unexpected(site.error());
  auto robot = core::config::Load<RobotModel>(options.robot.string());
  if (!robot) return tl::unexpected(robot.error());

  std::unique_ptr<SiteWorld> world(new SiteWorld);
  world->site_ = std::move(*site);
  world->robot_ = std::move(*robot);
  world->terrain_ = std::make_unique<const Terrain>(world->site_);
  world->scene_ = BuildScene(world->site_, *world->terrain_, SiteState::kAfter);
  if (options.lit) {
    auto lit = LitScene::Create(world->scene_, options.light);
    if (!lit) return tl::unexpected(lit.error());
    world->lit_ = std::move(*lit);
  } else {
    auto rays = RayScene::Create(world->scene_);
    if (!rays) return tl::unexpected(rays.error());
    world->rays_ = std::make_unique<const RayScene>(std::move(*rays));
  }

  Surroundings around;
  around.ground_height_m = [&terrain = *world->terrain_](double east_m, double north_m) {
    return terrain.GroundHeight(east_m, north_m);
  };
  const RayScene& rays = world->rays();
  around.blocked = [&rays, moment = rays.MomentAt(0.0)](const Eigen::Vector3d& from_enu_m,
                                                        double azimuth_rad, double elevation_rad) {
    const Eigen::Vector3d toward(std::sin(azimuth_rad) * std::cos(elevation_rad),
                                 std::cos(azimuth_rad) * std::cos(elevation_rad),
                                 std::sin(elevation_rad));
    return rays.Blocked(from_enu_m, toward, kSkyRange_m, moment);
  };
  around.steel = SteelOf(world->scene_);
  DriveScenario scenario{world->site_.origin.Geodetic(), options.begin, world->robot_,
                         PathOf(world->site_.path), options.seed};
  auto drive = SimulateDrive(scenario, around);
  if (!drive) {
    return core::Fail(drive.error().code, options.site.string() + ": " + drive.error().message);
  }
  world->drive_ = std::make_unique<const SimulatedDrive>(std::move(*drive));
  return world;
}

Eigen::Isometry3d SiteWorld::EnuFromCamera(core::GpsTime t) const {
  const MotionState state = trajectory().At(t);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = state.R_enu_body * vision::BodyFromCamera();
  pose.translation() = state.PointEnu(robot_.vehicle.camera_frd_m);
  return pose;
}

Eigen::Isometry3d SiteWorld::EnuFromScanner(const ScannerMount& mount, core::GpsTime t) const {
  const MotionState state = trajectory().At(t);
  const Eigen::Vector3d rpy_rad = mount.roll_pitch_yaw_deg * core::kRadFromDeg;
  const Eigen::Matrix3d R_body_mount =
      core::RotationNedFromBody({rpy_rad.x(), rpy_rad.y(), rpy_rad.z()});
  Eigen::Matrix3d R_mount_scanner;  // forward-right-down from right-ahead-up
  R_mount_scanner << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = state.R_enu_body * R_body_mount * R_mount_scanner;
  pose.translation() = state.PointEnu(mount.position_frd_m);
  return pose;
}

double SiteWorld::MissionSeconds(core::GpsTime t) const {
  return core::ToSeconds(t - trajectory().begin());
}

}  // namespace kawara::sim
