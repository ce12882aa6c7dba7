#pragma once
#include <cstdint>
#include <functional>
#include <kawara/changed_object_t.hpp>
#include <kawara/counters_t.hpp>
#include <kawara/event_t.hpp>
#include <kawara/object_texture_t.hpp>
#include <kawara/phase1_t.hpp>
#include <kawara/road_stations_t.hpp>
#include <kawara/robot_pose_t.hpp>
#include <list>
#include <map>
#include <string>

#include "comms/texture_message.hpp"
#include "core/expected.hpp"
#include "station/epoch_gaps.hpp"
#include "station/item.hpp"
#include "station/station_config.hpp"

namespace kawara::station {

struct IntakeStats {
  std::int64_t previews = 0;
  std::int64_t pictures = 0;
  std::int64_t poses = 0;          ///< heard
  std::int64_t poses_kept = 0;     ///< handed on
  std::int64_t poses_invalid = 0;  ///< the robot said so itself
  std::int64_t events = 0;
  std::int64_t objects = 0;        ///< revisions heard, with what was said again
  std::int64_t textures = 0;       ///< atlases put together
  std::int64_t stations = 0;       ///< of roads
  std::int64_t refused = 0;        ///< hostile or damaged: not in the store
  std::string last_refusal;        ///< one line about the latest of them
  std::int64_t leap_mismatch = 0;  ///< packets whose GPS - UTC is not this program's
};

/// Messages from the bus into records for the store. Believes nothing: names, sizes, ranges, NaN;
/// what is refused is counted. Decides by what the messages say only, never by when they come, so
/// that a log gives the records the live bus gave.
///
/// Of poses are kept every POSE.EPOCH and, of each robot's mission, the first POSE in each interval
/// of 1 / pose_rate_hz of GPS time. One thread only.
class Intake {
 public:
  using Sink = std::function<void(Item)>;
  Intake(const StationConfig& config, Sink sink);

  void OnPhase1(const phase1_t& packet, core::MonoTime received);
  void OnPose(const robot_pose_t& message, bool at_exposure, core::MonoTime received);
  void OnEvent(const event_t& event, core::MonoTime received);
  void OnCounters(const counters_t& counters);
  void OnObject(const changed_object_t& message, core::MonoTime received);
  void OnTexture(const object_texture_t& message, core::MonoTime received);
  void OnRoad(const road_stations_t& message, core::MonoTime received);

  const IntakeStats& stats() const { return stats_; }
  /// Pictures that the numbering says were sent and that never came; full ones, and previews.
  std::int64_t missing_pictures() const;
  std::int64_t missing_previews() const;
  std::int64_t late_pictures() const;
  /// The robot's own counters of lost things that are not zero: "log.dropped 3, link.tx.expired 1".
  std::string RobotLosses() const;

 private:
  struct Mission {
    std::string robot;
    std::string name;
    EpochGaps previews;
    EpochGaps pictures;
    std::int64_t last_slot = 0;  ///< interval of the latest POSE heard
    std::int64_t last_pose_ns = 0;
  };
  void Refuse(const std::string& what, const std::string& why);
  bool IsFirstOfItsPeriod(const gis::PoseRecord& record);
  /// Names of a report; false: refused.
  bool AreNames(const std::string& what, const std::string& robot, const std::string& mission);
  Mission& MissionOf(const std::string& robot, const std::string& name);

  StationConfig config_;
  Sink sink_;
  IntakeStats stats_;
  std::list<Mission> missions_;  ///< last heard in front, bounded
  std::int64_t forgotten_missing_ = 0;
  std::map<std::string, std::int64_t> losses_;
  comms::TextureAssembler atlases_;
};

}  // namespace kawara::station
