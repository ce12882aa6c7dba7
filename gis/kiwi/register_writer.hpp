#pragma once
#include <optional>
#include <string>

#include "gis/kiwi/kiwi_tables.hpp"
#include "gis/kiwi/object_register.hpp"
#include "gis/picture_folder.hpp"

namespace kawara::gis {

/// What all writes of a transaction share.
struct RegisterFrame {
  const core::LocalEnu& map;
  const std::string& survey;
  PictureFolder& textures;
  const std::string& uri_prefix;  ///< of texture files, from the store's folder
  Told told;
};

/// The rows of one transaction of an ObjectRegister. Records have been checked. Inside gis/kiwi
/// only.
class RegisterWriter {
 public:
  RegisterWriter(OgrDataset& dataset, const RegisterFrame& frame)
      : dataset_(dataset), frame_(frame), tables_(dataset, frame.told) {}

  /// Feature spaces and kp_meta, as far as they are not there.
  core::Expected<void> WriteFacts(std::optional<double> geoid_m);
  core::Expected<Registered> Add(const core::ChangedObject& object,
                                 const core::ObjectTextures& textures);
  /// Textures of a revision that is there without.
  core::Expected<Registered> AddLate(const std::string& uid, std::uint64_t revision,
                                     const core::ObjectTextures& textures);
  core::Expected<Registered> Add(const core::RoadStation& station, core::UtcTime begin);
  core::Expected<Registered> Add(const ModelRecord& model);
  /// Before the commit.
  core::Expected<void> Finish();

  static core::Expected<std::uint64_t> LastRevision(OgrDataset& dataset, const std::string& uid);

 private:
  /// The newest row of an object.
  struct Previous {
    std::int64_t revision = 0;
    core::UtcTime begin, end, last_seen;
    std::string outline_id;
    core::UprightBox box;
  };

  core::Expected<std::optional<Previous>> NewestRow(const std::string& uid);
  core::Expected<void> CloseRow(const std::string& uid, const Previous& row, core::UtcTime end,
                                core::UtcTime first_absent, bool keep_outline,
                                const core::ChangedObject& by);
  core::Expected<void> AddRows(const core::ChangedObject& object,
                               const core::ObjectTextures& textures, core::UtcTime begin,
                               core::UtcTime begin_min, const std::string& outline_to_keep);
  core::Expected<std::string> StageAtlas(const core::ChangedObject& object,
                                         const core::ObjectTextures& textures);
  core::Expected<void> AddTextures(const core::ChangedObject& object,
                                   const core::ObjectTextures& textures, const std::string& uri,
                                   core::UtcTime begin, core::UtcTime end);
  /// Creates a row: `fill(OGRFeature&)`.
  template <class Fill>
  core::Expected<void> Insert(const char* table, Fill&& fill);

  OgrDataset& dataset_;
  RegisterFrame frame_;
  KiwiTables tables_;
  std::set<const char*> touched_;
};

}  // namespace kawara::gis
