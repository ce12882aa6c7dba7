#pragma once
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "comms/event_log_writer.hpp"
#include "core/expected.hpp"
#include "core/measurements.hpp"
#include "sim/world/site_world.hpp"

namespace kawara::sim {

/// The truth of a drive through a simulated site as an LCM log, for kawara-log and lcm-logplayer:
///   TRUTH.OBJECT    truth_object_t, every standing thing, at the beginning
///   TRUTH.POSE      robot_pose_t of the body's reference point, at the instants of
///                   truth_trajectory.csv, 100 a second
///   TRUTH.EXPOSURE  truth_exposure_t
/// Entries are dated by the UTC of the simulated instant, so that the same drive gives the same
/// bytes. One thread.
class TruthRecorder {
 public:
  /// Makes `file` (an old one is replaced) and writes the objects. Poses begin at `begin`. `world`
  /// must outlive it. Errors: the file.
  static core::Expected<TruthRecorder> Create(const std::filesystem::path& file,
                                              const SiteWorld& world, core::GpsTime begin);

  /// Writes the poses up to `t`; going back does nothing.
  core::Expected<void> AdvanceTo(core::GpsTime t);
  /// The poses up to it, then the exposure. `mono`: on the machine's clock; not set without one.
  core::Expected<void> Exposure(std::int64_t trigger_sequence, std::int64_t frame_sequence,
                                core::GpsTime t, core::MonoTime mono);
  core::Expected<void> Close();

 private:
  TruthRecorder(comms::EventLogWriter writer, const SiteWorld& world, core::GpsTime begin)
      : writer_(std::move(writer)), world_(&world), next_pose_(FirstPose(world, begin)) {}
  static core::GpsTime FirstPose(const SiteWorld& world, core::GpsTime begin);
  core::Expected<void> WriteObjects(core::GpsTime begin);
  core::Pose PoseAt(core::GpsTime t, const Eigen::Vector3d& point_frd_m) const;
  template <class T>
  core::Expected<void> Append(core::GpsTime t, std::string_view channel, const T& message);

  comms::EventLogWriter writer_;
  const SiteWorld* world_;
  core::GpsTime next_pose_;
};

}  // namespace kawara::sim
