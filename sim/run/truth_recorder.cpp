#include "sim/run/truth_recorder.hpp"

#include <algorithm>
#include <array>
#include <kawara/robot_pose_t.hpp>
#include <kawara/truth_exposure_t.hpp>
#include <kawara/truth_object_t.hpp>
#include <limits>
#include <system_error>

#include "comms/codec.hpp"
#include "comms/convert.hpp"
#include "sim/site/truth_objects.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kPosePeriod = core::Milliseconds(10);

truth_object_t ToMessage(const SceneObject& object, const core::LocalEnu& enu) {
  const UprightBox box = VisibleBox(object);
  constexpr double kOpen = std::numeric_limits<double>::quiet_NaN();
  truth_object_t m{};
  m.id = static_cast<std::int32_t>(object.id);
  m.name = object.name;
  m.object_class = NameOf(object.cls);
  m.in_reference = object.in_reference ? 1 : 0;
  m.begin_s = object.begin_s.value_or(kOpen);
  m.end_s = object.end_s.value_or(kOpen);
  const core::Geodetic centre = enu.ToGeodetic(box.centre_enu_m);
  m.centre_lon_deg = centre.lon_rad * core::kDegFromRad;
  m.centre_lat_deg = centre.lat_rad * core::kDegFromRad;
  m.centre_h_m = centre.h_ellipsoidal_m;
  for (int i = 0; i < 3; ++i) m.size_m[i] = box.size_m[i];
  const double heading_deg = core::WrapPi(box.heading_rad) * core::kDegFromRad;
  m.heading_deg = heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg;
  const auto apexes = Apexes(box);
  for (std::size_t i = 0; i < apexes.size(); ++i) {
    const core::Geodetic apex = enu.ToGeodetic(apexes[i]);
    m.apex_lon_deg[i] = apex.lon_rad * core::kDegFromRad;
    m.apex_lat_deg[i] = apex.lat_rad * core::kDegFromRad;
    m.apex_h_m[i] = apex.h_ellipsoidal_m;
  }
  return m;
}

}  // namespace

core::Expected<TruthRecorder> TruthRecorder::Create(const std::filesystem::path& file,
                                                    const SiteWorld& world, core::GpsTime begin) {
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  comms::LogWriterOptions options;
  options.fdatasync = false;  // it can be made again
  auto writer = comms::EventLogWriter::Create(file, options);
  if (!writer) return tl::unexpected(writer.error());
  TruthRecorder recorder(std::move(*writer), world, begin);
  if (auto done = recorder.WriteObjects(begin); !done) return tl::unexpected(done.error());
  return recorder;
}

core::GpsTime TruthRecorder::FirstPose(const SiteWorld& world, core::GpsTime begin) {
  const core::GpsTime start = world.trajectory().begin();
  const std::int64_t period = kPosePeriod.count();
  const std::int64_t after = std::max<std::int64_t>((begin - start).count(), 0);
  return start + core::Nanoseconds((after + period - 1) / period * period);
}

template <class T>
core::Expected<void> TruthRecorder::Append(core::GpsTime t, std::string_view channel,
                                           const T& message) {
  const auto bytes = comms::Encode(message);
  if (!bytes) return tl::unexpected(bytes.error());
  // The writer's own clock, for its syncs, is the simulated one as well.
  return writer_.Append(core::ToUtc(t).ns() / 1000, channel, *bytes,
                        core::MonoTime::FromNs(t.ns()));
}

core::Expected<void> TruthRecorder::WriteObjects(core::GpsTime begin) {
  const core::LocalEnu enu(world_->scene().origin);
  for (const SceneObject& object : StandingObjects(world_->scene())) {
    if (auto done = Append(begin, "TRUTH.OBJECT", ToMessage(object, enu)); !done) return done;
  }
  return {};
}

core::Pose TruthRecorder::PoseAt(core::GpsTime t, const Eigen::Vector3d& point_frd_m) const {
  const Trajectory& motion = world_->trajectory();
  core::Pose pose;
  pose.time = t;
  pose.position = motion.GeodeticAt(t, point_frd_m);
  pose.attitude = motion.AttitudeAt(t);
  // Of the ENU axes at the site's origin; a site is so small that they are those of the place.
  pose.velocity_enu_mps = motion.At(t).PointVelocityEnu(point_frd_m);
  pose.rtk = core::RtkState::kFixed;
  pose.valid = true;
  return pose;
}

core::Expected<void> TruthRecorder::AdvanceTo(core::GpsTime t) {
  for (; next_pose_ <= t; next_pose_ += kPosePeriod) {
    robot_pose_t message;
    message.robot = "truth";
    message.pose = comms::ToMessage(PoseAt(next_pose_, Eigen::Vector3d::Zero()));
    if (auto done = Append(next_pose_, "TRUTH.POSE", message); !done) return done;
  }
  return {};
}

core::Expected<void> TruthRecorder::Exposure(std::int64_t trigger_sequence,
                                             std::int64_t frame_sequence, core::GpsTime t,
                                             core::MonoTime mono) {
  if (auto done = AdvanceTo(t); !done) return done;
  core::Pose camera = PoseAt(t, world_->robot().vehicle.camera_frd_m);
  camera.mono = mono;
  truth_exposure_t message;
  message.trigger_sequence = trigger_sequence;
  message.frame_sequence = frame_sequence;
  message.pose = comms::ToMessage(camera);
  return Append(t, "TRUTH.EXPOSURE", message);
}

core::Expected<void> TruthRecorder::Close() { return writer_.Close(); }

}  // namespace kawara::sim
