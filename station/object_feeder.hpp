#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <string>

#include "comms/object_message.hpp"
#include "comms/road_message.hpp"
#include "comms/texture_message.hpp"
#include "core/expected.hpp"
#include "gis/kiwi/object_register.hpp"

namespace kawara::station {

/// What became of everything added.
struct ObjectCounts {
  std::uint64_t revisions = 0;
  std::uint64_t textures = 0;
  std::uint64_t stations = 0;
  std::uint64_t known = 0;    ///< there already, or older than what is there: nothing changed
  std::uint64_t orphans = 0;  ///< textures of revisions that were never told
};

/// Changed objects, their textures and road stations into the register of the same store as
/// pictures and poses. Every robot's mission has a map of its own, so a register each: a few are
/// kept open. What Add has returned for is durable, but for textures
/// that came before their objects, which wait for them. Errors: those of ObjectRegister; the same
/// call again later is safe. One thread only.
class ObjectFeeder {
 public:
  /// `target`: as gis::StoreConfig's.
  explicit ObjectFeeder(std::string target) : target_(std::move(target)) {}

  core::Expected<void> Add(const comms::ObjectReport& report);
  core::Expected<void> Add(const comms::TextureReport& report);
  core::Expected<void> Add(const comms::RoadReport& report);
  /// Before the store's own: then one tidy file is left.
  core::Expected<void> Close();

  const ObjectCounts& counts() const { return counts_; }

 private:
  struct Mission {
    std::string robot, name;
    core::Geodetic origin;
    gis::ObjectRegister objects;
  };
  core::Expected<Mission*> Open(const std::string& robot, const std::string& mission,
                                const core::Geodetic& origin);
  void Count(gis::Registered answer, std::uint64_t& what);
  /// Textures that came before their revision, or before this program knew of its mission.
  core::Expected<void> AddWaiting(Mission& mission, const comms::ObjectReport& report);

  std::string target_;
  std::list<Mission> missions_;              ///< last used in front
  std::list<comms::TextureReport> waiting_;  ///< newest in front, bounded
  ObjectCounts counts_;
};

}  // namespace kawara::station
