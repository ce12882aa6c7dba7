#include "gis/kiwi/object_register.hpp"

#include <utility>

#include "gis/file_identity.hpp"
#include "gis/gdal_errors.hpp"
#include "gis/kiwi/check_object.hpp"
#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/kiwi/object_rows.hpp"
#include "gis/kiwi/register_writer.hpp"
#include "gis/picture_folder.hpp"
#include "gis/record_check.hpp"
#include "gis/store_schema.hpp"

namespace kawara::gis {

class ObjectRegister::Impl {
 public:
  Impl(RegisterConfig config, PictureFolder textures, std::string uri_prefix)
      : config_(std::move(config)),
        map_(config_.origin),
        textures_(std::move(textures)),
        uri_prefix_(std::move(uri_prefix)) {}

  core::Expected<void> Connect();
  core::Expected<void> Close();
  core::Expected<std::uint64_t> LastRevision(const std::string& uid);
  core::Expected<std::vector<core::ChangedObject>> ObjectsAt(core::UtcTime t);

  /// Runs `write(RegisterWriter&)` in one transaction.
  template <class Write>
  auto Transact(core::UtcTime told, Write&& write)
      -> decltype(write(std::declval<RegisterWriter&>()));

 private:
  RegisterConfig config_;
  core::LocalEnu map_;
  PictureFolder textures_;
  std::string uri_prefix_;
  std::optional<OgrDataset> dataset_;
  std::optional<FileIdentity> identity_;  ///< of the GeoPackage that is open
};

template <class Write>
auto ObjectRegister::Impl::Transact(core::UtcTime told, Write&& write)
    -> decltype(write(std::declval<RegisterWriter&>())) {
  if (auto connected = Connect(); !connected) return tl::unexpected(connected.error());
  if (auto begun = dataset_->Begin(); !begun) {
    dataset_.reset();
    return tl::unexpected(begun.error());
  }
  RegisterWriter writer(*dataset_, {.map = map_,
                                    .survey = config_.survey,
                                    .textures = textures_,
                                    .uri_prefix = uri_prefix_,
                                    .told = {told, config_.who}});
  auto answer = write(writer);
  core::Expected<void> done;
  if (!answer) done = tl::unexpected(answer.error());
  if (done) done = writer.Finish();
  if (done) done = textures_.Commit();
  if (done) done = dataset_->Commit();
  if (done) return answer;
  dataset_->Rollback();
  textures_.Abort();
  dataset_.reset();  // whatever state SQLite or the connection is in: begin afresh
  return tl::unexpected(done.error());
}

core::Expected<void> ObjectRegister::Impl::Connect() {
  // Somebody may have moved or deleted the file under us: rows would go to a file without a name.
  if (dataset_ && !dataset_->is_postgis() && IdentityOf(config_.target) != identity_)
    dataset_.reset();
  if (dataset_) return {};
  auto dataset = OpenStore(config_.target, KiwiSchema(), KiwiStyle);
  if (!dataset) return tl::unexpected(dataset.error());
  dataset_.emplace(std::move(*dataset));
  identity_ = IdentityOf(config_.target);
  return Transact({},
                  [this](RegisterWriter& writer) { return writer.WriteFacts(config_.geoid_m); });
}

core::Expected<void> ObjectRegister::Impl::Close() {
  if (dataset_ && !dataset_->is_postgis()) {
    // Refused while a reader has it open: then -wal and -shm stay, nothing is lost.
    static_cast<void>(dataset_->Execute("PRAGMA journal_mode = DELETE"));
  }
  dataset_.reset();
  return {};
}

core::Expected<std::uint64_t> ObjectRegister::Impl::LastRevision(const std::string& uid) {
  if (auto connected = Connect(); !connected) return tl::unexpected(connected.error());
  if (!IsCleanText(uid, kMaxNameBytes)) return 0;
  auto last = RegisterWriter::LastRevision(*dataset_, uid);
  if (!last) dataset_.reset();
  return last;
}

core::Expected<std::vector<core::ChangedObject>> ObjectRegister::Impl::ObjectsAt(core::UtcTime t) {
  if (auto connected = Connect(); !connected) return tl::unexpected(connected.error());
  const std::string now = std::to_string(t.ns());
  std::vector<core::ChangedObject> objects;
  core::Expected<void> read;
  auto done = dataset_->ForEach(std::string("SELECT * FROM ") + kChangedObject +
                                    " WHERE begin_ns <= " + now + " AND (end_ns IS NULL OR " + now +
                                    " < end_ns) ORDER BY id, revision",
                                [&](const OGRFeature& row) {
                                  auto object = ReadObject(row, map_);
                                  if (object) {
                                    objects.push_back(std::move(*object));
                                  } else if (read) {
                                    read = tl::unexpected(object.error());
                                  }
                                });
  if (!done) dataset_.reset();
  if (done) done = read;
  if (!done) return tl::unexpected(done.error());
  return objects;
}

core::Expected<ObjectRegister> ObjectRegister::Open(const RegisterConfig& config) {
  namespace fs = std::filesystem;
  const auto wrong = [](const std::string& what) {
    return core::Fail(core::ErrorCode::kInvalidArgument, "register of objects: " + what);
  };
  if (config.target.empty())
    return wrong("no store named (a .gpkg file, or PG:dbname=... for PostGIS)");
  if (config.survey.empty() || !IsCleanText(config.survey, kMaxNameBytes))
    return wrong("the survey needs a name of 1..64 clean bytes");
  if (!IsCleanText(config.who, kMaxNameBytes))
    return wrong("who registers: at most 64 clean bytes");
  RegisterConfig resolved = config;
  const bool postgis = OgrDataset::IsPostgis(config.target);
  std::error_code error;
  if (!postgis) resolved.target = fs::absolute(config.target, error).lexically_normal().string();
  if (!postgis && fs::is_directory(resolved.target, error))
    return wrong(resolved.target + " is a folder (name a file in it, such as changes.gpkg)");
  const fs::path home = postgis ? fs::current_path(error) : fs::path(resolved.target).parent_path();
  fs::path folder = config.textures_dir.empty()
                        ? home / "textures"
                        : fs::absolute(config.textures_dir, error).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();  // "textures/"
  const fs::path from = postgis ? folder.parent_path() : home;
  const std::string prefix = folder.lexically_relative(from).generic_string() + "/";
  auto textures = PictureFolder::Open(folder);
  if (!textures) return tl::unexpected(textures.error());
  auto impl = std::make_unique<Impl>(std::move(resolved), std::move(*textures), prefix);
  if (auto connected = impl->Connect(); !connected) return tl::unexpected(connected.error());
  return ObjectRegister(std::move(impl));
}

ObjectRegister::ObjectRegister(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ObjectRegister::ObjectRegister(ObjectRegister&&) noexcept = default;
ObjectRegister& ObjectRegister::operator=(ObjectRegister&&) noexcept = default;
ObjectRegister::~ObjectRegister() = default;

core::Expected<Registered> ObjectRegister::Register(const core::ChangedObject& object,
                                                    const core::ObjectTextures& textures,
                                                    core::UtcTime told) {
  if (auto checked = CheckObject(object); !checked) return tl::unexpected(checked.error());
  if (auto checked = CheckTextures(textures); !checked) return tl::unexpected(checked.error());
  return impl_->Transact(told,
                         [&](RegisterWriter& writer) { return writer.Add(object, textures); });
}

core::Expected<Registered> ObjectRegister::RegisterTextures(const std::string& uid,
                                                            std::uint64_t revision,
                                                            const core::ObjectTextures& textures,
                                                            core::UtcTime told) {
  if (auto checked = CheckTextures(textures); !checked) return tl::unexpected(checked.error());
  if (textures.atlas_jpeg.empty() || !IsCleanText(uid, kMaxNameBytes)) return Registered::kKnown;
  return impl_->Transact(
      told, [&](RegisterWriter& writer) { return writer.AddLate(uid, revision, textures); });
}

core::Expected<std::size_t> ObjectRegister::RegisterStations(
    std::span<const core::RoadStation> stations, core::UtcTime as_of, core::UtcTime told) {
  for (const core::RoadStation& station : stations) {
    if (auto checked = CheckStation(station); !checked) return tl::unexpected(checked.error());
    if (!station.observed.IsSet() && !as_of.IsSet())
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "road stations nobody looked at need a time from when that is known");
  }
  return impl_->Transact(told, [&](RegisterWriter& writer) -> core::Expected<std::size_t> {
    std::size_t added = 0;
    for (const core::RoadStation& station : stations) {
      const auto answer = writer.Add(station, station.observed.IsSet() ? station.observed : as_of);
      if (!answer) return tl::unexpected(answer.error());
      if (*answer == Registered::kAdded) ++added;
    }
    return added;
  });
}

core::Expected<Registered> ObjectRegister::RegisterModel(const ModelRecord& model) {
  const bool whole = model.footprint_m.size() >= 3 && model.begin.IsSet() &&
                     model.R_enu_file.allFinite() && !model.uri.empty() &&
                     IsCleanText(model.uri, kMaxTextBytes) &&
                     (!model.end.IsSet() || model.begin <= model.end);
  if (!whole)
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "model " + model.uri + ": needs a uri, a rotation, a footprint of 3 or more and its times");
  return impl_->Transact({}, [&](RegisterWriter& writer) { return writer.Add(model); });
}

core::Expected<std::uint64_t> ObjectRegister::LastRevision(const std::string& uid) {
  return impl_->LastRevision(uid);
}
core::Expected<std::vector<core::ChangedObject>> ObjectRegister::ObjectsAt(core::UtcTime t) {
  return impl_->ObjectsAt(t);
}
core::Expected<void> ObjectRegister::Close() { return impl_->Close(); }

}  // namespace kawara::gis
