#include "tests/bench/changes/change_drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "sim/dice.hpp"
#include "sim/render/light_cache.hpp"
#include "sim/site/reference_model.hpp"
#include "sim/site/scene_builder.hpp"
#include "sim/site/truth_objects.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/change/reference_builder.hpp"

namespace kawara::change_bench {
namespace {

constexpr double kCameraUp = 1.6;  // m above the road

template <class T>
T Must(core::Expected<T> value) {
  if (value) return std::move(*value);
  std::fprintf(stderr, "bench_changes: %s\n", value.error().message.c_str());
  std::exit(2);
}

bool IsChange(const sim::SceneObject& object) {
  return !object.in_reference &&
         (object.cls == sim::ObjectClass::kTruck || object.cls == sim::ObjectClass::kCar);
}

double Uniform(sim::Dice& dice, double reach) { return reach * (2.0 * dice.Uniform() - 1.0); }

/// The truck and the wagon of the paper stand a little elsewhere in every seed; what lies scattered
/// on the road is left out.
void Vary(sim::SiteConfig& site, std::uint64_t seed, bool vehicles) {
  sim::Dice dice(seed * 77 + 5);
  std::erase_if(site.scatter, [](const auto& s) { return s.name == "fallen"; });
  if (!vehicles)
    std::erase_if(site.things,
                  [](const auto& t) { return t.name == "truck" || t.name == "wagon"; });
  for (auto& thing : site.things) {
    if (thing.name != "truck" && thing.name != "wagon") continue;
    thing.at_m[0] += Uniform(dice, 2.0);
    thing.at_m[1] += Uniform(dice, 0.25);
    thing.heading_deg += Uniform(dice, 3.0);
  }
}

}  // namespace

Errors Errors::Hard() {
  Errors e;
  e.shared = 0.30;
  e.outlier_blocks = 0.15;
  return e;
}

ChangeDrive::ChangeDrive(const Options& options) : options_(options) {
  site_ = Must(sim::LoadSite(options.site));
  Vary(site_, options.seed, options.vehicles);
  terrain_ = std::make_unique<sim::Terrain>(site_);
  const sim::Scene after = sim::BuildScene(site_, *terrain_, sim::SiteState::kAfter);
  before_ = std::make_unique<sim::RayScene>(
      Must(sim::RayScene::Create(sim::BuildScene(site_, *terrain_, sim::SiteState::kBefore))));
  after_ = std::make_unique<sim::RayScene>(Must(sim::RayScene::Create(after)));
  for (const sim::SceneObject& object : after.objects) {
    if (!IsChange(object)) continue;
    const sim::UprightBox box = sim::VisibleBox(object);
    truth_.push_back({object.name, {box.centre_enu_m, box.size_m, box.heading_rad}});
  }
  const auto geometry = vision::PanoramaGeometry::Band(
      options.columns, {-50.0 * core::kRadFromDeg, 35.0 * core::kRadFromDeg});
  camera_ = std::make_shared<vision::EquirectangularCamera>(
      Must(vision::EquirectangularCamera::Create(geometry)));
  rays_ = std::make_unique<vision::CameraRays>(*camera_);
  // What of the changes can be seen at all: the true hits of every tenth picture.
  std::vector<std::uint32_t> ids;
  for (const sim::SceneObject& object : after.objects)
    if (IsChange(object)) ids.push_back(object.id);
  const auto moment = after_->MomentAt(0.0);
  for (int i = 0; i < options.pictures; i += 5) {
    const Eigen::Isometry3d pose = TruePose(i);
    for (std::size_t pixel = 0; pixel < rays_->pixels(); pixel += 3) {
      const Eigen::Vector3d ray = pose.linear() * rays_->ray(pixel).cast<double>();
      if (!ray.allFinite()) continue;
      const sim::RayHit hit = after_->Cast(pose.translation(), ray, moment);
      if (!hit.hit() || hit.range_m > 8.0 ||
          std::find(ids.begin(), ids.end(), hit.object) == ids.end())
        continue;
      change_samples_.emplace_back(pose.translation() + hit.range_m * ray);
    }
  }
}

core::Expected<std::shared_ptr<const sim::LitScene>> ChangeDrive::Lit() const {
  sim::LightSettings light;
  light.cache = sim::LightCache::DefaultFolder();
  return sim::LitScene::Create(sim::BuildScene(site_, *terrain_, sim::SiteState::kAfter), light);
}

Eigen::Isometry3d ChangeDrive::PoseAt(double east_m) const {
  // Along the robot's own way through the site.
  const auto& way = site_.path.points;
  Eigen::Vector2d at(east_m, 0.0), tangent(1.0, 0.0);
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Eigen::Vector2d a(way[i - 1].at_m[0], way[i - 1].at_m[1]),
        b(way[i].at_m[0], way[i].at_m[1]);
    if (east_m < a.x() || east_m > b.x()) continue;
    at = a + (b - a) * ((east_m - a.x()) / (b.x() - a.x()));
    tangent = (b - a).normalized();
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << at, terrain_->GroundHeight(at.x(), at.y()) + kCameraUp;
  pose.linear().col(0) = Eigen::Vector3d::UnitZ();
  pose.linear().col(1) = Eigen::Vector3d(tangent.y(), -tangent.x(), 0.0);
  pose.linear().col(2) = Eigen::Vector3d(tangent.x(), tangent.y(), 0.0);
  return pose;
}

Eigen::Isometry3d ChangeDrive::TruePose(int i) const {
  const double share = static_cast<double>(i) / std::max(1, options_.pictures - 1);
  return PoseAt(options_.from_m + share * (options_.to_m - options_.from_m));
}

vision::RangeImage ChangeDrive::Cast(const sim::RayScene& scene,
                                     const Eigen::Isometry3d& pose) const {
  vision::RangeImage image;
  image.Reset(rays_->width_px(), rays_->height_px());
  const auto moment = scene.MomentAt(0.0);
  const Eigen::Matrix3d R = pose.linear();
  const auto run = [&](std::size_t begin, std::size_t end) {
    sim::RayPacket packet;
    sim::PacketHits hits;
    for (std::size_t pixel = begin; pixel < end; pixel += sim::kPacketRays) {
      const std::size_t lanes = std::min<std::size_t>(sim::kPacketRays, end - pixel);
      packet.lanes = 0;
      for (std::size_t k = 0; k < lanes; ++k) {
        const Eigen::Vector3d ray = R * rays_->ray(pixel + k).cast<double>();
        if (!ray.allFinite()) continue;
        packet.Set(static_cast<int>(k), pose.translation(), ray.normalized(), 30.0F);
        packet.lanes |= 1U << k;
      }
      scene.Intersect(packet, moment, hits);
      for (std::size_t k = 0; k < lanes; ++k)
        if ((packet.lanes >> k & 1U) != 0 && hits.triangle[k] != sim::kNoTriangle)
          image.range_m[pixel + k] = hits.range_m[k];
    }
  };
  const std::size_t half = rays_->pixels() / 2 / 16 * 16;
  std::thread other(run, 0, half);
  run(half, rays_->pixels());
  other.join();
  return image;
}

Picture ChangeDrive::Take(int i, const Errors& errors, std::uint64_t draw) const {
  Picture picture{Cast(*after_, TruePose(i)), TruePose(i)};
  vision::RangeImage& image = picture.ranges;
  sim::Dice dice(draw * 1000003 + static_cast<std::uint64_t>(i) * 101 + 7);
  sim::Dice pose_dice(draw * 7919 + static_cast<std::uint64_t>(i / 20) * 31 + 3);
  constexpr int kBlock = 8;
  const int columns = (image.width_px + kBlock - 1) / kBlock;
  const int rows = (image.height_px + kBlock - 1) / kBlock;
  struct Block {
    bool shared, elsewhere;
    double error, place;
  };
  std::vector<Block> blocks;
  for (int k = 0; k < columns * rows; ++k)
    blocks.push_back({dice.Uniform() < errors.shared, dice.Uniform() < errors.outlier_blocks,
                      dice.Normal(), 1.0 + 11.0 * dice.Uniform()});
  for (int v = 0; v < image.height_px; ++v)
    for (int u = 0; u < image.width_px; ++u) {
      float& range = image.range_m[image.index(u, v)];
      if (std::isnan(range)) continue;
      const Block& block = blocks[static_cast<std::size_t>(v / kBlock * columns + u / kBlock)];
      const double sd = std::max(0.005, errors.sd_per_m2 * double{range} * double{range});
      const double chance = dice.Uniform(), normal = dice.Normal(), place = dice.Uniform();
      double measured = double{range} + sd * (block.shared ? block.error : normal);
      if (chance < errors.outliers) measured = 1.0 + 11.0 * place;
      if (block.elsewhere) measured = block.place + 0.1 * normal;
      range = static_cast<float>(std::max(0.3, measured));
      // The matcher states what its disparity is good for at the range it believes.
      image.sd_m[image.index(u, v)] =
          static_cast<float>(std::max(0.005, errors.sd_per_m2 * double{range} * double{range}));
    }
  Eigen::Isometry3d& pose = picture.map_from_camera;
  pose.translation() += errors.offset_m;
  pose.translation() += Eigen::Vector3d(errors.position_sd_m * pose_dice.Normal(),
                                        errors.position_sd_m * pose_dice.Normal(),
                                        errors.up_sd_m * pose_dice.Normal());
  const double turn = errors.offset_heading_rad + errors.heading_sd_rad * pose_dice.Normal();
  pose.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * pose.linear();
  return picture;
}

std::vector<Eigen::Vector3d> ChangeDrive::LaserPoints(int scans, double sd_m) const {
  std::vector<Eigen::Vector3d> points;
  sim::Dice dice(options_.seed * 13 + 1);
  for (int i = 0; i < scans; ++i) {
    const double share = static_cast<double>(i) / std::max(1, scans - 1);
    const Eigen::Isometry3d pose =
        PoseAt(options_.from_m - 5.0 + share * (options_.to_m - options_.from_m + 10.0));
    const vision::RangeImage image = Cast(*before_, pose);
    for (std::size_t pixel = 0; pixel < rays_->pixels(); ++pixel) {
      if (std::isnan(image.range_m[pixel]) || image.range_m[pixel] > 25.0F) continue;
      const double range = double{image.range_m[pixel]} + sd_m * dice.Normal();
      points.emplace_back(pose * (range * rays_->ray(pixel).cast<double>()));
    }
  }
  return points;
}

vision::ReferenceMap ChangeDrive::Reference() const {
  constexpr double kLaserSd = 0.02;
  vision::ReferenceBuilder builder;
  builder.Begin({"laser drive before", "laser", core::UtcTime{}, kLaserSd});
  builder.AddPoints(LaserPoints(60, kLaserSd));
  return builder.Finish(true);
}

vision::RoadArea ChangeDrive::Road() const {
  vision::RoadPolygon polygon;
  polygon.name = "carriageway";
  for (const Eigen::Vector3d& p : sim::RoadPolygon(site_, *terrain_, false))
    polygon.outer.emplace_back(p.head<2>());
  return Must(vision::RoadArea::Make({polygon}));
}

double ChangeDrive::DistanceToChange(const Eigen::Vector3d& p) const {
  double nearest = 1e9;
  for (const Eigen::Vector3d& s : change_samples_)
    nearest = std::min(nearest, (s - p).squaredNorm());
  return std::sqrt(nearest);
}

}  // namespace kawara::change_bench
