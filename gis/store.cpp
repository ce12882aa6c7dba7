#include "gis/store.hpp"

#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "gis/file_identity.hpp"
#include "gis/gdal_errors.hpp"
#include "gis/ogr_dataset.hpp"
#include "gis/picture_folder.hpp"
#include "gis/record_check.hpp"
#include "gis/row_writer.hpp"
#include "gis/store_schema.hpp"
#include "gis/tracks.hpp"

namespace kawara::gis {
namespace {

using Record = std::variant<PoseRecord, PanoramaRecord, EventRecord>;

std::size_t BytesOf(const PoseRecord& r) { return sizeof r + r.robot.size() + r.mission.size(); }
std::size_t BytesOf(const EventRecord& r) {
  return sizeof r + r.robot.size() + r.mission.size() + r.name.size() + r.text.size();
}
std::size_t BytesOf(const PanoramaRecord& r) {
  return sizeof r + r.robot.size() + r.mission.size() + (r.jpeg ? r.jpeg->size() : 0);
}

}  // namespace

class SpatioTemporalStore::Impl {
 public:
  Impl(StoreConfig config, PictureFolder pictures, std::string uri_prefix)
      : config_(std::move(config)),
        pictures_(std::move(pictures)),
        uri_prefix_(std::move(uri_prefix)) {}

  core::Expected<void> Connect();
  template <class R>
  core::Expected<void> Add(const R& record);
  core::Expected<void> Flush(bool all_tracks);
  core::Expected<void> Close();

  std::size_t pending() const { return pending_.size(); }
  const StoreStats& stats() const { return stats_; }
  const std::filesystem::path& pictures_dir() const { return pictures_.path(); }

 private:
  core::Expected<StoreStats> Write(bool all_tracks);
  void Disconnect();

  StoreConfig config_;
  PictureFolder pictures_;
  std::string uri_prefix_;
  std::optional<OgrDataset> dataset_;
  std::optional<FileIdentity> identity_;
  Tracks tracks_;
  std::vector<Record> pending_;
  std::size_t pending_bytes_ = 0;
  StoreStats stats_;
};

core::Expected<void> SpatioTemporalStore::Impl::Connect() {
  // Somebody may have moved or deleted the file under us: rows would go to a file without a name.
  if (dataset_ && !dataset_->is_postgis() && IdentityOf(config_.target) != identity_) Disconnect();
  if (dataset_) return {};
  auto dataset = OpenStore(config_.target);
  if (!dataset) return tl::unexpected(dataset.error());
  dataset_.emplace(std::move(*dataset));
  identity_ = IdentityOf(config_.target);
  auto mended = Tracks::Mend(*dataset_);
  if (!mended) Disconnect();
  return mended;
}

void SpatioTemporalStore::Impl::Disconnect() {
  tracks_.Clear();
  dataset_.reset();
}

template <class R>
core::Expected<void> SpatioTemporalStore::Impl::Add(const R& record) {
  if (auto checked = CheckRecord(record); !checked) return checked;
  const std::size_t bytes = BytesOf(record);
  if (pending_bytes_ + bytes > config_.max_pending_bytes)
    return core::Fail(core::ErrorCode::kFull,
                      std::to_string(pending_.size()) + " records wait for the store already");
  pending_.emplace_back(record);
  pending_bytes_ += bytes;
  return {};
}

/// Everything pending in one transaction; the pictures are durable before it is committed.
core::Expected<StoreStats> SpatioTemporalStore::Impl::Write(bool all_tracks) {
  if (auto begun = dataset_->Begin(); !begun) return tl::unexpected(begun.error());
  RowWriter writer(*dataset_, pictures_, tracks_, uri_prefix_);
  core::Expected<void> done;
  for (const Record& record : pending_) {
    if (!done) break;
    done = std::visit([&writer](const auto& r) { return writer.Apply(r); }, record);
  }
  if (done) done = writer.Finish(all_tracks);
  if (done) done = pictures_.Commit();
  if (done) done = dataset_->Commit();
  if (done) return writer.stats();
  dataset_->Rollback();
  return tl::unexpected(done.error());
}

core::Expected<void> SpatioTemporalStore::Impl::Flush(bool all_tracks) {
  if (pending_.empty() && !all_tracks) return {};
  if (auto connected = Connect(); !connected) return connected;
  const auto written = Write(all_tracks);
  if (!written) {
    pictures_.Abort();
    Disconnect();  // whatever state SQLite or the connection is in: begin afresh
    return tl::unexpected(written.error());
  }
  pending_.clear();
  pending_bytes_ = 0;
  stats_.poses += written->poses;
  stats_.panoramas += written->panoramas;
  stats_.upgrades += written->upgrades;
  stats_.events += written->events;
  stats_.duplicates += written->duplicates;
  ++stats_.commits;
  return {};
}

core::Expected<void> SpatioTemporalStore::Impl::Close() {
  auto flushed = Flush(true);
  if (flushed && dataset_ && !dataset_->is_postgis()) {
    // One file to carry away. Refused while a reader has it open: then -wal and -shm stay, nothing
    // is lost.
    static_cast<void>(dataset_->Execute("PRAGMA journal_mode = DELETE"));
  }
  if (flushed) Disconnect();
  return flushed;
}

core::Expected<SpatioTemporalStore> SpatioTemporalStore::Open(const StoreConfig& config) {
  if (config.target.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "no store named (a .gpkg file, or PG:dbname=... for PostGIS)");
  namespace fs = std::filesystem;
  StoreConfig resolved = config;
  const bool postgis = OgrDataset::IsPostgis(config.target);
  std::error_code error;
  if (!postgis) resolved.target = fs::absolute(config.target, error).lexically_normal().string();
  if (!postgis && fs::is_directory(resolved.target, error))
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      resolved.target + ": is a folder (name a file in it, such as store.gpkg)");
  const fs::path home = postgis ? fs::current_path(error) : fs::path(resolved.target).parent_path();
  fs::path folder = config.pictures_dir.empty()
                        ? home / "pictures"
                        : fs::absolute(config.pictures_dir, error).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();  // "pictures/"
  // A database has no folder of its own: there the picture folder's own name begins every uri.
  const fs::path from = postgis ? folder.parent_path() : home;
  const std::string prefix = folder.lexically_relative(from).generic_string() + "/";
  auto pictures = PictureFolder::Open(folder);
  if (!pictures) return tl::unexpected(pictures.error());
  auto impl = std::make_unique<Impl>(std::move(resolved), std::move(*pictures), prefix);
  if (auto connected = impl->Connect(); !connected) return tl::unexpected(connected.error());
  return SpatioTemporalStore(std::move(impl));
}

SpatioTemporalStore::SpatioTemporalStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SpatioTemporalStore::SpatioTemporalStore(SpatioTemporalStore&&) noexcept = default;
SpatioTemporalStore& SpatioTemporalStore::operator=(SpatioTemporalStore&&) noexcept = default;
SpatioTemporalStore::~SpatioTemporalStore() = default;

core::Expected<void> SpatioTemporalStore::AddPose(const PoseRecord& pose) {
  return impl_->Add(pose);
}
core::Expected<void> SpatioTemporalStore::AddPanorama(const PanoramaRecord& panorama) {
  return impl_->Add(panorama);
}
core::Expected<void> SpatioTemporalStore::AddEvent(const EventRecord& event) {
  return impl_->Add(event);
}
core::Expected<void> SpatioTemporalStore::Flush() { return impl_->Flush(false); }
core::Expected<void> SpatioTemporalStore::Close() { return impl_->Close(); }
std::size_t SpatioTemporalStore::pending() const { return impl_->pending(); }
const StoreStats& SpatioTemporalStore::stats() const { return impl_->stats(); }
const std::filesystem::path& SpatioTemporalStore::pictures_dir() const {
  return impl_->pictures_dir();
}

}  // namespace kawara::gis
