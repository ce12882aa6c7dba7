#pragma once
#include <kawara/ahrs_sample_t.hpp>
#include <kawara/changed_object_t.hpp>
#include <kawara/clock_t.hpp>
#include <kawara/command_answer_t.hpp>
#include <kawara/command_t.hpp>
#include <kawara/config_t.hpp>
#include <kawara/corrections_t.hpp>
#include <kawara/counters_t.hpp>
#include <kawara/event_t.hpp>
#include <kawara/frame_t.hpp>
#include <kawara/gnss_fix_t.hpp>
#include <kawara/log_crc_t.hpp>
#include <kawara/navigation_t.hpp>
#include <kawara/object_texture_t.hpp>
#include <kawara/phase1_t.hpp>
#include <kawara/pose_t.hpp>
#include <kawara/raw_bytes_t.hpp>
#include <kawara/road_stations_t.hpp>
#include <kawara/robot_pose_t.hpp>
#include <kawara/truth_exposure_t.hpp>
#include <kawara/truth_object_t.hpp>
#include <type_traits>

namespace kawara::comms {

/// Calls f(std::type_identity<T>{}) for every message type of comms/lcmtypes.
template <class F>
void ForEachMessageType(F&& f) {
  const auto each = [&f]<class... T>(std::type_identity<T>... type) { (f(type), ...); };
  each(std::type_identity<ahrs_sample_t>{}, std::type_identity<changed_object_t>{},
       std::type_identity<clock_t>{}, std::type_identity<command_answer_t>{},
       std::type_identity<command_t>{}, std::type_identity<config_t>{},
       std::type_identity<corrections_t>{}, std::type_identity<counters_t>{},
       std::type_identity<event_t>{}, std::type_identity<frame_t>{},
       std::type_identity<gnss_fix_t>{}, std::type_identity<log_crc_t>{},
       std::type_identity<navigation_t>{}, std::type_identity<object_texture_t>{},
       std::type_identity<phase1_t>{}, std::type_identity<pose_t>{},
       std::type_identity<raw_bytes_t>{}, std::type_identity<road_stations_t>{},
       std::type_identity<robot_pose_t>{}, std::type_identity<truth_exposure_t>{},
       std::type_identity<truth_object_t>{});
}

}  // namespace kawara::comms
