#include "gis/row_writer.hpp"

#include <ogrsf_frmts.h>

#include <array>
#include <cstdio>

#include "gis/record_check.hpp"
#include "gis/rows.hpp"

namespace kawara::gis {
namespace {

tl::unexpected<core::Error> NoLayer(const char* layer) {
  return core::Fail(core::ErrorCode::kIo, std::string("the store has lost its layer ") + layer);
}

/// "rover-1/20260827T062523Z/000012.jpg", or "000012_preview.jpg".
std::string PicturePath(const PanoramaRecord& r) {
  std::array<char, 48> file{};
  std::snprintf(file.data(), file.size(), "%06lld%s.jpg", static_cast<long long>(r.epoch),
                r.stage == PictureStage::kPreview ? "_preview" : "");
  return SafePathName(r.robot) + "/" + SafePathName(r.mission) + "/" + file.data();
}

}  // namespace

core::Expected<core::GpsTime> RowWriter::Insert(const char* layer, const std::string& robot,
                                                core::GpsTime t) {
  const std::string table = layer;
  const std::string same_robot = " WHERE robot = " + SqlText(robot) + " AND gps_ns ";
  const std::string now = std::to_string(t.ns());
  if (auto closed = dataset_.Execute(
          "UPDATE " + table + " SET t_end = " + SqlText(IsoUtc(UtcOf(t))) + same_robot +
          "= (SELECT max(gps_ns) FROM " + table + same_robot + "< " + now + ")");
      !closed)
    return tl::unexpected(closed.error());
  const auto next =
      dataset_.QueryInteger("SELECT min(gps_ns) AS n FROM " + table + same_robot + "> " + now);
  if (!next) return tl::unexpected(next.error());
  return core::GpsTime::FromNs(next->value_or(0));
}

core::Expected<void> RowWriter::Apply(const PoseRecord& r) {
  std::optional<std::int64_t> fid;
  bool at_exposure = false;
  auto found = dataset_.ForEach("SELECT fid + 0 AS n, source FROM obs_pose WHERE robot = " +
                                    SqlText(r.robot) + " AND mission = " + SqlText(r.mission) +
                                    " AND gps_ns = " + std::to_string(r.pose.time.ns()),
                                [&](const OGRFeature& row) {
                                  fid = row.GetFieldAsInteger64(0);
                                  at_exposure = std::string(row.GetFieldAsString(1)) == "exposure";
                                });
  if (!found) return found;
  if (fid && (at_exposure || !r.at_exposure)) {
    ++stats_.duplicates;
    return {};
  }
  const auto next = Insert(kObsPose, r.robot, r.pose.time);
  if (!next) return tl::unexpected(next.error());
  OGRLayer* layer = dataset_.Layer(kObsPose);
  if (layer == nullptr) return NoLayer(kObsPose);
  OGRFeature feature(layer->GetLayerDefn());
  if (fid) feature.SetFID(*fid);
  Fill(feature, r);
  SetEnd(feature, *next);
  if (auto written = dataset_.Write(*layer, feature); !written) return written;
  touched_pose_ = true;
  if (!fid) ++stats_.poses;
  return tracks_.Add(dataset_, r.robot, r.mission, VertexOf(r.pose));
}

core::Expected<void> RowWriter::Apply(const PanoramaRecord& r) {
  std::optional<std::int64_t> fid;
  bool has_full = false;
  std::string preview_uri;
  std::int64_t gps_ns = 0;
  auto found = dataset_.ForEach(
      "SELECT fid + 0 AS n, stage, preview_uri, gps_ns FROM obs_panorama WHERE robot = " +
          SqlText(r.robot) + " AND mission = " + SqlText(r.mission) +
          " AND epoch = " + std::to_string(r.epoch),
      [&](const OGRFeature& row) {
        fid = row.GetFieldAsInteger64(0);
        has_full = std::string(row.GetFieldAsString(1)) == ToString(PictureStage::kFull);
        preview_uri = row.GetFieldAsString(2);
        gps_ns = row.GetFieldAsInteger64(3);
      });
  if (!found) return found;
  const bool full = r.stage == PictureStage::kFull;
  const bool known = full ? has_full : !preview_uri.empty();
  if (fid && (known || gps_ns != r.pose.time.ns())) {  // another time: not the same exposure
    ++stats_.duplicates;
    return {};
  }
  if (auto staged = pictures_.Stage(PicturePath(r), *r.jpeg); !staged) return staged;
  touched_panorama_ = true;
  if (fid) return Replace(r, *fid, has_full, preview_uri);
  const auto next = Insert(kObsPanorama, r.robot, r.pose.time);
  if (!next) return tl::unexpected(next.error());
  OGRLayer* layer = dataset_.Layer(kObsPanorama);
  if (layer == nullptr) return NoLayer(kObsPanorama);
  OGRFeature feature(layer->GetLayerDefn());
  const std::string uri = uri_prefix_ + PicturePath(r);
  Fill(feature, r, {.uri = uri, .preview_uri = full ? "" : uri});
  SetEnd(feature, *next);
  ++stats_.panoramas;
  return dataset_.Write(*layer, feature);
}

core::Expected<void> RowWriter::Replace(const PanoramaRecord& r, std::int64_t fid, bool has_full,
                                        const std::string& preview_uri) {
  OGRLayer* layer = dataset_.Layer(kObsPanorama);
  if (layer == nullptr) return NoLayer(kObsPanorama);
  const OGRFeatureUniquePtr feature{layer->GetFeature(fid)};
  if (!feature)
    return core::Fail(core::ErrorCode::kIo, "a row of obs_panorama cannot be read back");
  const std::string uri = uri_prefix_ + PicturePath(r);
  if (has_full) {  // the preview came last
    feature->SetField("preview_uri", uri.c_str());
  } else {
    Fill(*feature, r, {.uri = uri, .preview_uri = preview_uri});
    ++stats_.upgrades;
  }
  return dataset_.Write(*layer, *feature);
}

core::Expected<void> RowWriter::Apply(const EventRecord& r) {
  const auto there = dataset_.QueryInteger(
      "SELECT count(*) AS n FROM event_log WHERE robot = " + SqlText(r.robot) +
      " AND mission = " + SqlText(r.mission) + " AND mono_ns = " + std::to_string(r.mono.ns()) +
      " AND name = " + SqlText(r.name) + " AND text = " + SqlText(r.text));
  if (!there) return tl::unexpected(there.error());
  if (there->value_or(0) > 0) {
    ++stats_.duplicates;
    return {};
  }
  OGRLayer* layer = dataset_.Layer(kEventLog);
  if (layer == nullptr) return NoLayer(kEventLog);
  OGRFeature feature(layer->GetLayerDefn());
  Fill(feature, r);
  touched_event_ = true;
  ++stats_.events;
  return dataset_.Write(*layer, feature);
}

core::Expected<void> RowWriter::Finish(bool all_tracks) {
  if (auto written = tracks_.Write(dataset_, all_tracks); !written) return written;
  const std::array<std::pair<bool, const char*>, 3> touched{
      {{touched_pose_, kObsPose}, {touched_panorama_, kObsPanorama}, {touched_event_, kEventLog}}};
  for (const auto& [yes, name] : touched) {
    if (!yes) continue;
    OGRLayer* layer = dataset_.Layer(name);
    if (layer == nullptr) return NoLayer(name);
    if (auto synced = dataset_.Sync(*layer, "t_begin"); !synced) return synced;
  }
  return {};
}

}  // namespace kawara::gis
