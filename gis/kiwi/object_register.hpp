#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/object_textures.hpp"

namespace kawara::gis {

struct RegisterConfig {
  /// A GeoPackage file or "PG:..." as StoreConfig's; may be the file or database that holds the
  /// poses and pictures of a SpatioTemporalStore.
  std::string target;
  /// Folder of the texture files. Empty: "textures" beside the GeoPackage, or in the working folder
  /// for PostGIS.
  std::filesystem::path textures_dir = {};
  core::Geodetic origin;  ///< of the map's plane, the frame of all records that go in and out
  std::string survey;     ///< the survey's (mission's) name
  std::string who;        ///< robot or person that registers, for kp_tx
  /// Geoid above the ellipsoid at the origin [m], for kp_meta; not set: not stated.
  std::optional<double> geoid_m = {};
};

/// What became of a record.
enum class Registered : std::uint8_t {
  kAdded,   ///< a new row; an older one of the object was closed
  kClosed,  ///< the object is gone: its row was closed
  kKnown    ///< this revision (observation) or a newer one is there already: nothing changed
};

/// A textured model of the 2nd update, for kp_model.
struct ModelRecord {
  std::string uri;
  core::Geodetic origin;  ///< of the file's frame
  /// Takes the file's axes to east, north, up at its origin (VRML97: Y up).
  Eigen::Matrix3d R_enu_file = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Vector3d> footprint_m;  ///< 3 or more, the map's frame
  core::UtcTime begin, end;                  ///< of the pictures it was made of
};

/// The register of what changed: every revision of an object becomes KIWI+ elements (kp_*) and a
/// row of changed_object, every observation of a place of the road likewise (road_station).
///
/// History: nothing is overwritten. A new revision closes the rows of the one before it and adds
/// its own; "gone" closes and adds nothing; what was written stays but for its end. A first
/// revision begins to exist when it was first seen; a later one where it is first seen after the
/// beginning of the one before (it moved), else when it was last seen. What exists at T:
/// begin <= T < end. Each call is one transaction: it is durable, with its texture files, when it
/// has returned, or nothing of it happened. A revision that is known, or older than a known one,
/// changes nothing: sending it again is safe. Pure: rows are a function of the calls; no wall clock
/// (kp_tx takes its time from the caller). Errors: kInvalidArgument (the record), those of the
/// store else; then a later call tries again on a fresh connection. One thread.
class ObjectRegister {
 public:
  /// Makes the tables, or opens those that are there and goes on with them.
  static core::Expected<ObjectRegister> Open(const RegisterConfig& config);
  ~ObjectRegister();
  ObjectRegister(ObjectRegister&&) noexcept;
  ObjectRegister& operator=(ObjectRegister&&) noexcept;

  /// `told`: when this store was told, for kp_tx; not set: not noted. Gone without ever having been
  /// registered: added and closed at once.
  core::Expected<Registered> Register(const core::ChangedObject& object,
                                      const core::ObjectTextures& textures = {},
                                      core::UtcTime told = {});
  /// Textures that come after their revision. kKnown: there is no such revision, or it has its
  /// textures; nothing changed.
  core::Expected<Registered> RegisterTextures(const std::string& uid, std::uint64_t revision,
                                              const core::ObjectTextures& textures,
                                              core::UtcTime told = {});
  /// All in one transaction. A station exists from when it was observed (nobody looked: from
  /// `as_of`) until it is observed again. Answers how many rows were added.
  core::Expected<std::size_t> RegisterStations(std::span<const core::RoadStation> stations,
                                               core::UtcTime as_of, core::UtcTime told = {});
  core::Expected<Registered> RegisterModel(const ModelRecord& model);

  /// Newest revision known, those that closed it counted; 0: there is no such object.
  core::Expected<std::uint64_t> LastRevision(const std::string& uid);
  /// What existed at a time, by uid: what a next mission takes up with its ids.
  core::Expected<std::vector<core::ChangedObject>> ObjectsAt(core::UtcTime t);

  /// One file to carry away: no -wal beside it. Everything registered is durable without.
  core::Expected<void> Close();

 private:
  class Impl;
  explicit ObjectRegister(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::gis
