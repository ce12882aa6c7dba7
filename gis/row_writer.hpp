#pragma once
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "gis/ogr_dataset.hpp"
#include "gis/picture_folder.hpp"
#include "gis/records.hpp"
#include "gis/store.hpp"
#include "gis/tracks.hpp"

namespace kawara::gis {

/// Puts records into the layers inside one transaction of the caller, so that the result depends on
/// the set of records only: finds what is there, closes the row before, opens the new one towards
/// the row after, stages the pictures that new rows name. Inside gis/ only.
class RowWriter {
 public:
  /// `uri_prefix`: the picture folder as seen from the store's folder, "pictures/".
  RowWriter(OgrDataset& dataset, PictureFolder& pictures, Tracks& tracks, std::string uri_prefix)
      : dataset_(dataset),
        pictures_(pictures),
        tracks_(tracks),
        uri_prefix_(std::move(uri_prefix)) {}

  core::Expected<void> Apply(const PoseRecord& record);
  core::Expected<void> Apply(const PanoramaRecord& record);
  core::Expected<void> Apply(const EventRecord& record);
  /// Trajectories that have grown enough, extents and change stamps of the layers touched.
  core::Expected<void> Finish(bool all_tracks);

  /// What Apply did; counts once the transaction is committed.
  const StoreStats& stats() const { return stats_; }

 private:
  /// The last rows of the robot before t end at t. Returns when the first row after t begins.
  core::Expected<core::GpsTime> Insert(const char* layer, const std::string& robot,
                                       core::GpsTime t);
  core::Expected<void> Replace(const PanoramaRecord& record, std::int64_t fid, bool has_full,
                               const std::string& preview_uri);

  OgrDataset& dataset_;
  PictureFolder& pictures_;
  Tracks& tracks_;
  std::string uri_prefix_;
  StoreStats stats_;
  bool touched_pose_ = false;
  bool touched_panorama_ = false;
  bool touched_event_ = false;
};

}  // namespace kawara::gis
