#pragma once
#include <array>
#include <cstdint>

#include "core/changed_object.hpp"

namespace kawara::gis {

/// Colour of a size class on every map and in every export: sRGB.
constexpr std::array<std::uint8_t, 3> ClassColour(core::SizeClass cls) {
  switch (cls) {
    case core::SizeClass::kTruck:
      return {215, 48, 39};
    case core::SizeClass::kCar:
      return {252, 141, 89};
    case core::SizeClass::kRubble:
      return {140, 81, 10};
    case core::SizeClass::kPerson:
      return {69, 117, 180};
    case core::SizeClass::kUnknown:
      break;
  }
  return {118, 42, 131};
}

/// Of the road: more than half not looked at, nothing passes, the narrowest vehicle, more.
constexpr std::array<std::uint8_t, 3> StationColour(const core::RoadStation& station) {
  if (station.unknown_share > 0.5) return {150, 150, 150};
  if (station.passable_class == 0) return {215, 25, 28};
  if (station.passable_class == 1) return {253, 174, 97};
  return {26, 150, 65};
}

}  // namespace kawara::gis
