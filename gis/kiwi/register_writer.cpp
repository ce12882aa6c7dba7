#include "gis/kiwi/register_writer.hpp"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <memory>

#include "core/iso8601.hpp"
#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/kiwi/object_elements.hpp"
#include "gis/kiwi/object_rows.hpp"
#include "gis/kiwi/row_fields.hpp"
#include "gis/model/text.hpp"
#include "gis/record_check.hpp"

namespace kawara::gis {
namespace {

bool Same(const core::UprightBox& a, const core::UprightBox& b) {
  // The stored box went through degrees and back: equal to the nanometre.
  constexpr double kSameM = 1e-8, kSameRad = 1e-11;
  return (a.centre_m - b.centre_m).cwiseAbs().maxCoeff() < kSameM && a.size_m == b.size_m &&
         std::abs(core::WrapPi(a.heading_rad - b.heading_rad)) < kSameRad;
}

/// "t_end = '...', end_ns = ...".
std::string SetEndSql(core::UtcTime end) {
  return "t_end = " + SqlText(IsoUtc(end)) + ", end_ns = " + std::to_string(end.ns());
}

std::string Evidence(const core::ObjectTextures& textures) {
  std::vector<std::string> sources;
  for (const core::FaceTexture& face : textures.faces) {
    const bool new_one = std::find(sources.begin(), sources.end(), face.source) == sources.end();
    if (!face.source.empty() && new_one) sources.push_back(face.source);
  }
  std::string all;
  for (const std::string& source : sources) all.append(all.empty() ? "" : " ").append(source);
  return all;
}

}  // namespace

template <class Fill>
core::Expected<void> RegisterWriter::Insert(const char* table, Fill&& fill) {
  OGRLayer* layer = dataset_.Layer(table);
  if (layer == nullptr)
    return core::Fail(core::ErrorCode::kIo, std::string("the store has lost its layer ") + table);
  OGRFeature feature(layer->GetLayerDefn());
  fill(feature);
  touched_.insert(table);
  return dataset_.Write(*layer, feature);
}

core::Expected<void> RegisterWriter::WriteFacts(std::optional<double> geoid_m) {
  core::Expected<void> done;
  for (const FeatureSpace& space : FeatureSpaces()) {
    if (done) done = tables_.Write(space);
  }
  const auto fact = [&](const std::string& key, const std::string& value) {
    if (done) done = tables_.WriteMeta(key, value);
  };
  // The offset in force for today's data; a later leap second is a new fact under a new key.
  const int gps_minus_utc_s =
      core::LeapSeconds().OffsetAt(core::FromCivil({2017, 1, 1, 0, 0, 0, 0}));
  fact("profile", "Kawaraban's open profile of KIWI+ notions, version 1");
  fact("horizontal", "WGS 84 (ITRF) longitude and latitude in degrees, IEEE double");
  fact("vertical", "metres above the WGS 84 ellipsoid");
  fact("time", "UTC, ISO 8601, milliseconds cut; existence is t_begin <= T < t_end");
  fact("gps_minus_utc_s", std::to_string(gps_minus_utc_s) + " since 2017-01-01");
  const std::string survey = "survey." + frame_.survey;
  const core::Geodetic& origin = frame_.map.origin();
  fact(survey + ".origin", OriginText(origin));
  if (geoid_m) fact(survey + ".geoid_above_ellipsoid_m", Number(*geoid_m, 4));
  return done;
}

core::Expected<std::uint64_t> RegisterWriter::LastRevision(OgrDataset& dataset,
                                                           const std::string& uid) {
  std::uint64_t last = 0;
  auto done = dataset.ForEach(
      std::string("SELECT revision, ended_by FROM ") + kChangedObject +
          " WHERE id = " + SqlText(uid),
      [&last](const OGRFeature& row) {
        for (int i = 0; i < 2; ++i) {
          if (row.IsFieldSetAndNotNull(i))
            last = std::max(last, static_cast<std::uint64_t>(row.GetFieldAsInteger64(i)));
        }
      });
  if (!done) return tl::unexpected(done.error());
  return last;
}

core::Expected<std::optional<RegisterWriter::Previous>> RegisterWriter::NewestRow(
    const std::string& uid) {
  std::optional<Previous> newest;
  core::Expected<void> read;
  auto done = dataset_.ForEach(std::string("SELECT * FROM ") + kChangedObject + " WHERE id = " +
                                   SqlText(uid) + " ORDER BY revision DESC LIMIT 1",
                               [&](const OGRFeature& row) {
                                 const auto object = ReadObject(row, frame_.map);
                                 if (!object) {
                                   read = tl::unexpected(object.error());
                                   return;
                                 }
                                 newest = Previous{static_cast<std::int64_t>(object->revision),
                                                   GetNs(row, "begin_ns"),
                                                   GetNs(row, "end_ns"),
                                                   object->last_seen,
                                                   row.GetFieldAsString("outline_id"),
                                                   object->box};
                               });
  if (done) done = read;
  if (!done) return tl::unexpected(done.error());
  return newest;
}

core::Expected<void> RegisterWriter::CloseRow(const std::string& uid, const Previous& row,
                                              core::UtcTime end, core::UtcTime first_absent,
                                              bool keep_outline, const core::ChangedObject& by) {
  const std::string revision = std::to_string(row.revision);
  const std::string which = " = " + SqlText(uid) + " AND revision = " + revision;
  const std::string t_end = " SET t_end = " + SqlText(IsoUtc(end));
  auto done = dataset_.Execute(std::string("UPDATE ") + kChangedObject + " SET " + SetEndSql(end) +
                               ", ended_by = " + std::to_string(by.revision) + ", ended_as = " +
                               SqlText(core::ToString(by.state)) + " WHERE id" + which);
  const std::string of_revision = t_end + " WHERE object_uid" + which;
  for (const char* table : {kBoxTable, kTextureTable}) {
    if (done) done = dataset_.Execute(std::string("UPDATE ") + table + of_revision);
  }
  const std::string connector = uid + "/" + revision;
  if (done) done = tables_.Close(ElementKind::kConnector, connector, end);
  if (done) done = tables_.CloseBounds(connector, std::min(row.last_seen, end), first_absent);
  if (done && !keep_outline) done = tables_.Close(ElementKind::kVector, row.outline_id, end);
  return done;
}

core::Expected<std::string> RegisterWriter::StageAtlas(const core::ChangedObject& object,
                                                       const core::ObjectTextures& textures) {
  if (textures.atlas_jpeg.empty()) return std::string();
  const std::string path =
      object.uid + "/" + object.uid + "_r" + std::to_string(object.revision) + ".jpg";
  if (auto staged = frame_.textures.Stage(path, textures.atlas_jpeg); !staged)
    return tl::unexpected(staged.error());
  return frame_.uri_prefix + path;
}

core::Expected<void> RegisterWriter::AddTextures(const core::ChangedObject& object,
                                                 const core::ObjectTextures& textures,
                                                 const std::string& uri, core::UtcTime begin,
                                                 core::UtcTime end) {
  core::Expected<void> done;
  for (const core::FaceTexture& face : textures.faces) {
    if (!done) break;
    done = Insert(kTextureTable, [&](OGRFeature& f) {
      SetTextAlways(f, "object_uid", object.uid);
      SetInteger(f, "revision", static_cast<std::int64_t>(object.revision));
      SetTextAlways(f, "face", core::ToString(face.side));
      SetTextAlways(f, "uri", uri);
      SetInteger(f, "width_px", textures.width_px);
      SetInteger(f, "height_px", textures.height_px);
      for (std::size_t i = 0; i < face.corners_px.size(); ++i) {
        const std::string corner = "corner" + std::to_string(i);
        SetReal(f, (corner + "_x_px").c_str(), face.corners_px[i][0]);
        SetReal(f, (corner + "_y_px").c_str(), face.corners_px[i][1]);
      }
      SetText(f, "source", face.source);
      SetTime(f, "taken", face.taken);
      SetReal(f, "seen_share", face.seen_share);
      SetTime(f, "t_begin", begin);
      SetTime(f, "t_end", end);
    });
  }
  return done;
}

core::Expected<void> RegisterWriter::AddRows(const core::ChangedObject& object,
                                             const core::ObjectTextures& textures,
                                             core::UtcTime begin, core::UtcTime begin_min,
                                             const std::string& outline_to_keep) {
  const auto uri = StageAtlas(object, textures);
  if (!uri) return tl::unexpected(uri.error());
  ElementSet elements = ElementsOf(object, frame_.map, begin);
  if (!outline_to_keep.empty()) elements.vectors.clear();  // the same line stands on
  const RowFrame row{.begin = begin,
                     .survey = frame_.survey,
                     .texture_uri = *uri,
                     .evidence = Evidence(textures),
                     .outline_id = outline_to_keep.empty() ? OutlineId(object) : outline_to_keep};
  auto done = tables_.Write(elements);
  if (done)
    done = tables_.WriteBounds(elements.connector.id, {.begin_min = begin_min, .begin_max = begin});
  if (done) done = Insert(kBoxTable, [&](OGRFeature& f) { FillBox(f, object, frame_.map, row); });
  if (done) done = AddTextures(object, textures, *uri, begin, {});
  if (done)
    done = Insert(kChangedObject, [&](OGRFeature& f) { FillObject(f, object, frame_.map, row); });
  return done;
}

core::Expected<Registered> RegisterWriter::Add(const core::ChangedObject& object,
                                               const core::ObjectTextures& textures) {
  const auto last = LastRevision(dataset_, object.uid);
  if (!last) return tl::unexpected(last.error());
  if (object.revision <= *last) return Registered::kKnown;
  const auto previous = NewestRow(object.uid);
  if (!previous) return tl::unexpected(previous.error());
  const bool gone = object.state == core::ChangeState::kGone;
  core::Expected<void> done;
  if (!*previous) {
    done = AddRows(object, textures, object.first_seen, object.last_absent, "");
    if (done && gone)
      done = CloseRow(object.uid,
                      {.revision = static_cast<std::int64_t>(object.revision),
                       .begin = object.first_seen,
                       .end = {},
                       .last_seen = object.last_seen,
                       .outline_id = OutlineId(object),
                       .box = object.box},
                      object.gone, object.gone, false, object);
    if (!done) return tl::unexpected(done.error());
    return Registered::kAdded;
  }
  Previous row = **previous;
  const bool stands = !row.end.IsSet();
  const core::UtcTime floor = stands ? row.begin : row.end;
  if (gone) {
    // It had ended by an older "gone" already: this one only counts as known from now on.
    row.last_seen = std::max(row.last_seen, object.last_seen);
    done = CloseRow(object.uid, row, stands ? std::max(object.gone, floor) : row.end, object.gone,
                    false, object);
    if (!done) return tl::unexpected(done.error());
    return Registered::kClosed;
  }
  const core::UtcTime begin =
      object.first_seen > floor ? object.first_seen : std::max(object.last_seen, floor);
  const bool keep_outline = stands && Same(row.box, object.box);
  if (stands) done = CloseRow(object.uid, row, begin, begin, keep_outline, object);
  const core::UtcTime begin_min =
      stands ? std::min(row.last_seen, begin) : std::max(row.end, object.last_absent);
  if (done) done = AddRows(object, textures, begin, begin_min, keep_outline ? row.outline_id : "");
  if (!done) return tl::unexpected(done.error());
  return Registered::kAdded;
}

core::Expected<Registered> RegisterWriter::AddLate(const std::string& uid, std::uint64_t revision,
                                                   const core::ObjectTextures& textures) {
  const std::string which = " = " + SqlText(uid) + " AND revision = " + std::to_string(revision);
  bool bare = false;
  core::UtcTime begin, end;
  auto done = dataset_.ForEach(std::string("SELECT begin_ns, end_ns, texture_uri FROM ") +
                                   kChangedObject + " WHERE id" + which,
                               [&](const OGRFeature& row) {
                                 begin = GetNs(row, "begin_ns");
                                 end = GetNs(row, "end_ns");
                                 bare = !row.IsFieldSetAndNotNull(row.GetFieldIndex("texture_uri"));
                               });
  if (!done) return tl::unexpected(done.error());
  if (!bare) return Registered::kKnown;
  core::ChangedObject object;
  object.uid = uid;
  object.revision = revision;
  const auto uri = StageAtlas(object, textures);
  if (!uri) return tl::unexpected(uri.error());
  done = AddTextures(object, textures, *uri, begin, end);
  if (done)
    done = dataset_.Execute(std::string("UPDATE ") + kChangedObject +
                            " SET texture_uri = " + SqlText(*uri) + " WHERE id" + which);
  if (done)
    done = dataset_.Execute(std::string("UPDATE ") + kBoxTable + " SET evidence = " +
                            SqlText(Evidence(textures)) + " WHERE object_uid" + which);
  if (!done) return tl::unexpected(done.error());
  return Registered::kAdded;
}

core::Expected<Registered> RegisterWriter::Add(const core::RoadStation& station,
                                               core::UtcTime begin) {
  const std::string uid = SqlText(StationUid(station));
  const auto newest = dataset_.QueryInteger(std::string("SELECT max(begin_ns) AS n FROM ") +
                                            kRoadStation + " WHERE id = " + uid);
  if (!newest) return tl::unexpected(newest.error());
  if (*newest && begin.ns() <= **newest) return Registered::kKnown;
  std::vector<std::string> open;
  auto done = dataset_.ForEach(
      std::string("SELECT element_id FROM ") + kRoadStation +
          " WHERE end_ns IS NULL AND id = " + uid,
      [&open](const OGRFeature& row) { open.emplace_back(row.GetFieldAsString(0)); });
  for (const std::string& id : open) {
    if (done) done = tables_.Close(ElementKind::kConnector, id, begin);
    if (done) done = tables_.Close(ElementKind::kVector, id + "/across", begin);
  }
  if (done && !open.empty())
    done = dataset_.Execute(std::string("UPDATE ") + kRoadStation + " SET " + SetEndSql(begin) +
                            " WHERE end_ns IS NULL AND id = " + uid);
  const ElementSet elements = ElementsOf(station, frame_.map, begin);
  if (done) done = tables_.Write(elements);
  const RowFrame row{
      .begin = begin, .survey = frame_.survey, .texture_uri = {}, .evidence = {}, .outline_id = {}};
  if (done)
    done = Insert(kRoadStation, [&](OGRFeature& f) {
      FillStation(f, station, frame_.map, row, elements.connector.id);
    });
  if (!done) return tl::unexpected(done.error());
  return Registered::kAdded;
}

core::Expected<Registered> RegisterWriter::Add(const ModelRecord& model) {
  const auto there = dataset_.QueryInteger(std::string("SELECT count(*) AS n FROM ") + kModelTable +
                                           " WHERE uri = " + SqlText(model.uri));
  if (!there) return tl::unexpected(there.error());
  if (there->value_or(0) > 0) return Registered::kKnown;
  auto done = Insert(kModelTable, [&](OGRFeature& f) {
    SetTextAlways(f, "uri", model.uri);
    SetTextAlways(f, "class_code", kClassModel);
    SetReal(f, "origin_lon_deg", model.origin.lon_rad * core::kDegFromRad);
    SetReal(f, "origin_lat_deg", model.origin.lat_rad * core::kDegFromRad);
    SetReal(f, "origin_h_m", model.origin.h_ellipsoidal_m);
    std::string rotation;
    for (int i = 0; i < 9; ++i)
      rotation.append(i > 0 ? " " : "").append(Number(model.R_enu_file(i / 3, i % 3), 12));
    SetTextAlways(f, "rotation_to_enu", rotation);
    SetTime(f, "t_begin", model.begin);
    SetTime(f, "t_end", model.end);
    auto ring = std::make_unique<OGRLinearRing>();
    for (std::size_t i = 0; i <= model.footprint_m.size(); ++i) {
      const core::Geodetic g =
          frame_.map.ToGeodetic(model.footprint_m[i % model.footprint_m.size()]);
      ring->addPoint(g.lon_rad * core::kDegFromRad, g.lat_rad * core::kDegFromRad,
                     g.h_ellipsoidal_m);
    }
    auto polygon = std::make_unique<OGRPolygon>();
    polygon->addRingDirectly(ring.release());
    f.SetGeometryDirectly(polygon.release());
  });
  if (!done) return tl::unexpected(done.error());
  return Registered::kAdded;
}

core::Expected<void> RegisterWriter::Finish() {
  for (const char* table : touched_) {
    OGRLayer* layer = dataset_.Layer(table);
    if (layer == nullptr) continue;
    if (auto synced = dataset_.Sync(*layer, "t_begin"); !synced) return synced;
  }
  touched_.clear();
  return tables_.Finish();
}

}  // namespace kawara::gis
