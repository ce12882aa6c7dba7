#pragma once
#include <cstddef>
#include <kawara/changed_object_t.hpp>
#include <string>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"

namespace kawara::comms {

/// LCM bytes of a changed_object_t at most: one packet of the narrowest link.
constexpr std::size_t kMaxObjectBytes = 1000;

/// A changed object with what a receiver must know to place it.
struct ObjectReport {
  std::string robot;
  std::string mission;
  core::Geodetic origin;  ///< of the plane the object's box is in
  core::ChangedObject object;
};

/// kInvalidArgument: names too long for kMaxObjectBytes (five robots' names of 64 bytes fit), or a
/// figure beyond 63 bits.
[[nodiscard]] core::Expected<changed_object_t> ToMessage(const ObjectReport& report);
/// Of messages from outside: kFormat for an enumeration out of range, a place off the globe, a
/// number that is none, or a count below zero. Angles come back within a rounding, the rest as it
/// was.
[[nodiscard]] core::Expected<ObjectReport> FromMessage(const changed_object_t& message);

}  // namespace kawara::comms
