#pragma once
#include <kawara/road_stations_t.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"

namespace kawara::comms {

/// LCM bytes of a road_stations_t at most.
constexpr std::size_t kMaxRoadBytes = 1000;

/// Road stations with what a receiver must know to place them.
struct RoadReport {
  std::string robot;
  std::string mission;
  core::Geodetic origin;  ///< of the plane the stations are in
  std::vector<core::RoadStation> stations;
};

/// As many messages as it takes: each of one road and of kMaxRoadBytes at most. Widths to a tenth
/// of a millimetre. Errors: kInvalidArgument: names so long that not one station fits.
[[nodiscard]] core::Expected<std::vector<road_stations_t>> ToMessages(const RoadReport& report);
/// Of messages from outside: kFormat for a place off the globe, a number that is none, or a share
/// or class out of range.
[[nodiscard]] core::Expected<RoadReport> FromMessage(const road_stations_t& message);

}  // namespace kawara::comms
