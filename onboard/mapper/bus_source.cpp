#include "onboard/mapper/bus_source.hpp"

#include <cmath>
#include <kawara/phase1_t.hpp>
#include <utility>

#include "comms/typed_bus.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/panorama_metadata.hpp"

namespace kawara::mapper {
namespace {

constexpr std::int8_t kFullPicture = 1;
/// Compressed pictures that may wait for the mapper: 20 MB of them, and ten metres.
constexpr std::size_t kRoom = 40;
/// Of the step asked for, as PairMaker allows.
constexpr double kAllowance = 0.85;

/// Of the panorama's camera, in a map at `origin`.
Eigen::Isometry3d MapFromCamera(const core::LocalEnu& map, const core::Geodetic& origin,
                                const core::Geodetic& place, const core::Attitude& attitude) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = map.FromGeodetic(place);
  pose.linear() = core::RotationEnuFromNed(origin, place) * core::RotationNedFromBody(attitude);
  return pose;
}

}  // namespace

core::Expected<std::unique_ptr<BusSource>> BusSource::Open(std::unique_ptr<comms::Bus> bus,
                                                           const BusSourceOptions& options) {
  std::unique_ptr<BusSource> source(new BusSource(std::move(bus), options));
  if (auto done = source->Listen(); !done) return tl::unexpected(done.error());
  if (options.live) options.say("waits for pictures on channel PHASE1");
  while (source->waiting_.empty()) {
    if (source->bus_->AtEnd()) {
      return core::Fail(core::ErrorCode::kFormat,
                        "no full picture with pose and geometry on channel PHASE1 of the log: "
                        "record with kawara-onboard, RTK fixed or float");
    }
    if (source->asked_to_stop()) {
      return core::Fail(core::ErrorCode::kUnavailable,
                        "no picture came on channel PHASE1: is kawara-onboard running on this bus, "
                        "with a valid pose?");
    }
    const auto handled = source->bus_->HandleFor(core::Milliseconds(200));
    if (!handled) return tl::unexpected(handled.error());
  }
  if (options.live) source->thread_ = std::thread([raw = source.get()] { raw->Run(); });
  return source;
}

BusSource::~BusSource() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

core::Expected<void> BusSource::Listen() {
  return comms::Subscribe<phase1_t>(
      *bus_, "PHASE1", [this](const phase1_t& packet, const comms::MessageMeta&) {
        if (packet.stage != kFullPicture || !packet.pose.valid || packet.pose.gps_ns <= 0) return;
        Take(packet.robot, packet.mission, packet.pose.gps_ns, packet.jpeg);
      });
}

bool BusSource::MakeRig(std::span<const std::uint8_t> jpeg) {
  const auto metadata = vision::ReadPanoramaMetadata(jpeg);
  if (!metadata || metadata->geometry.width_px == 0 || !metadata->position) return false;
  auto camera = vision::EquirectangularCamera::Create(metadata->geometry);
  if (!camera) return false;
  survey::SurveyCamera one;
  one.model = std::make_shared<const vision::EquirectangularCamera>(std::move(*camera));
  one.body_from_camera.linear() = vision::BodyFromCamera();
  rig_.cameras = {one};
  rig_.origin = options_.origin ? options_.origin : metadata->position;
  return true;
}

void BusSource::Take(const std::string& robot, const std::string& mission, std::int64_t gps_ns,
                     std::span<const std::uint8_t> jpeg) {
  if (robot_.empty()) robot_ = robot;
  if (mission_.empty() && robot == robot_) mission_ = mission;
  const auto number = static_cast<std::uint64_t>(gps_ns);
  if (robot != robot_ || number <= last_number_) return;
  const auto metadata = vision::ReadPanoramaMetadata(jpeg);
  const bool usable = metadata && metadata->position && metadata->attitude &&
                      (!rig_.cameras.empty() || MakeRig(jpeg));
  if (!usable) {
    if (unusable_++ == 0) {
      options_.say("warning: a picture of PHASE1 has no pose or geometry inside; it is left out");
    }
    return;
  }
  Stop stop;
  stop.number = number;
  stop.time = core::GpsTime::FromNs(gps_ns);
  const core::LocalEnu map(*rig_.origin);
  stop.map_from_body = MapFromCamera(map, *rig_.origin, *metadata->position, *metadata->attitude);
  const Eigen::Vector3d here = stop.map_from_body.translation();
  if (any_ && (here - last_place_).norm() < kAllowance * options_.step_m) return;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance.topLeftCorner<3, 3>() = metadata->position_cov_enu_m2;
  covariance.diagonal().tail<3>() = metadata->attitude_sd_rad.cwiseAbs2();
  if (covariance.trace() > 0.0) stop.covariance = covariance;
  const auto bytes = std::make_shared<const std::vector<std::uint8_t>>(jpeg.begin(), jpeg.end());
  const auto load = [bytes, size = metadata->geometry]() -> core::Expected<SharedPicture> {
    auto picture = survey::DecodePicture(*bytes);
    if (!picture) return tl::unexpected(picture.error());
    if (picture->width_px != size.width_px || picture->height_px != size.height_px) {
      return core::Fail(core::ErrorCode::kFormat,
                        "a picture of PHASE1 is not of the size its GPano block states");
    }
    return std::make_shared<const survey::Picture>(std::move(*picture));
  };
  stop.pictures.push_back({0, "epoch " + std::to_string(metadata->epoch), load});

  const std::lock_guard lock(mutex_);
  if (options_.live && waiting_.size() >= kRoom) {
    if (dropped_++ == 0) {
      options_.say("warning: pictures come faster than they can be used: some are left out");
    }
    return;
  }
  any_ = true;
  last_place_ = here;
  last_number_ = number;
  waiting_.push_back(std::move(stop));
  changed_.notify_all();
}

void BusSource::Run() {
  const auto ended = [this] {
    const std::lock_guard lock(mutex_);
    return ended_;
  };
  core::Expected<void> failed;
  while (failed && !asked_to_stop() && !ended()) {
    const auto handled = bus_->HandleFor(core::Milliseconds(200));
    if (!handled) failed = tl::unexpected(handled.error());
  }
  const std::lock_guard lock(mutex_);
  ended_ = true;
  failed_ = failed;
  changed_.notify_all();
}

core::Expected<std::optional<Stop>> BusSource::Next() {
  if (!options_.live) {
    while (waiting_.empty() && !bus_->AtEnd() && !asked_to_stop()) {
      const auto handled = bus_->HandleFor(core::Milliseconds(200));
      if (!handled) return tl::unexpected(handled.error());
    }
  }
  std::unique_lock lock(mutex_);
  if (options_.live) changed_.wait(lock, [this] { return !waiting_.empty() || ended_; });
  if (waiting_.empty()) {
    if (!failed_) return tl::unexpected(failed_.error());
    return std::optional<Stop>();
  }
  Stop stop = std::move(waiting_.front());
  waiting_.pop_front();
  return stop;
}

}  // namespace kawara::mapper
