#pragma once
#include <string>

#include "core/changed_object.hpp"
#include "core/geodesy.hpp"
#include "gis/kiwi/elements.hpp"

/// Changed things and the road's state in the words of KIWI+. Pure functions.
namespace kawara::gis {

/// Ids of a revision's elements: "UID/REVISION" and "UID/REVISION/outline".
std::string ConnectorId(const core::ChangedObject& object);
std::string OutlineId(const core::ChangedObject& object);

/// The box's floor as one closed outline of four vectors, foot and height as its height pair, and
/// a connector in the middle with every figure of the object as attribute. Exact for a box level
/// where it stands; in a map's plane far from its origin it is not, then the pair spans all eight
/// apexes and the flag kLossy says so (kp_box holds the apexes as they are).
ElementSet ElementsOf(const core::ChangedObject& object, const core::LocalEnu& map,
                      core::UtcTime begin);

/// "ROAD@ALONG_m", the same for all observations of the place.
std::string StationUid(const core::RoadStation& station);
/// The line across the road from the left to the right edge, and a connector in the middle of the
/// gap (of the road, where there is none) with what is left to pass.
ElementSet ElementsOf(const core::RoadStation& station, const core::LocalEnu& map,
                      core::UtcTime begin);

/// "front left": the sides that were seen; "": none.
std::string SidesSeen(const core::ChangedObject& object);

}  // namespace kawara::gis
