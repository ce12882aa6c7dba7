#include "gis/kiwi/kiwi_schema.hpp"

#include <array>

namespace kawara::gis {
namespace {

using enum FieldType;

constexpr auto kFeatureSpaceFields = std::to_array<Field>({
    {"class_code", kText, true},
    {"name", kText, true},
    {"dim", kText, true},
    {"parent", kText, false},
});

constexpr auto kVectorFields = std::to_array<Field>({
    {"id", kText, true},
    {"class_code", kText, true},
    {"flags", kInteger, true},
    {"base_elev_m", kReal, true},
    {"rel_height_m", kReal, true},
    {"t_begin", kTime, true},
    {"t_end", kTime, false},
});

constexpr auto kConnectorFields = std::to_array<Field>({
    {"id", kText, true},
    {"class_code", kText, true},
    {"flags", kInteger, true},
    {"base_elev_m", kReal, true},
    {"rel_height_m", kReal, true},
    {"t_begin", kTime, true},
    {"t_end", kTime, false},
    {"object_uid", kText, true},
});

constexpr auto kAttributeFields = std::to_array<Field>({
    {"connector_id", kText, true},
    {"key", kText, true},
    {"value", kText, true},
    {"unit", kText, false},
});

constexpr auto kModelFields = std::to_array<Field>({
    {"uri", kText, true},
    {"class_code", kText, true},
    {"origin_lon_deg", kReal, true},
    {"origin_lat_deg", kReal, true},
    {"origin_h_m", kReal, true},
    {"rotation_to_enu", kText, true},  // row by row, of the file's axes
    {"t_begin", kTime, true},
    {"t_end", kTime, false},
});

constexpr auto kBoundsFields = std::to_array<Field>({
    {"element_id", kText, true},
    {"begin_min", kTime, false},
    {"begin_max", kTime, false},
    {"end_min", kTime, false},
    {"end_max", kTime, false},
});

constexpr auto kTxFields = std::to_array<Field>({
    {"element_id", kText, true},
    {"tx_begin", kTime, true},
    {"tx_end", kTime, false},
    {"who", kText, true},
});

constexpr auto kMetaFields = std::to_array<Field>({
    {"key", kText, true},
    {"value", kText, true},
});

constexpr auto kTextureFields = std::to_array<Field>({
    {"object_uid", kText, true},
    {"revision", kInteger, true},
    {"face", kText, true},
    {"uri", kText, true},  // relative to the folder of the store
    {"width_px", kInteger, true},
    {"height_px", kInteger, true},
    {"corner0_x_px", kReal, true},
    {"corner0_y_px", kReal, true},
    {"corner1_x_px", kReal, true},
    {"corner1_y_px", kReal, true},
    {"corner2_x_px", kReal, true},
    {"corner2_y_px", kReal, true},
    {"corner3_x_px", kReal, true},
    {"corner3_y_px", kReal, true},
    {"source", kText, false},
    {"taken", kTime, false},
    {"seen_share", kReal, true, true},  // of the side that pictures show
    {"t_begin", kTime, true},
    {"t_end", kTime, false},
});

/// One list after the other.
template <std::size_t... kN>
constexpr auto Joined(const std::array<Field, kN>&... parts) {
  std::array<Field, (kN + ...)> all{};
  std::size_t next = 0;
  const auto append = [&](const auto& part) {
    for (const Field& field : part) all[next++] = field;
  };
  (append(parts), ...);
  return all;
}

// What kp_box and changed_object both say of a box.
constexpr auto kBoxFigures = std::to_array<Field>({
    {"revision", kInteger, true},    {"t_begin", kTime, true},
    {"t_end", kTime, false},         {"first_seen", kTime, true},
    {"last_seen", kTime, true},      {"centre_lon_deg", kReal, true},
    {"centre_lat_deg", kReal, true}, {"centre_h_m", kReal, true},
    {"length_m", kReal, true},       {"width_m", kReal, true},
    {"height_m", kReal, true},       {"heading_deg", kReal, true},  // true, at its centre
    {"sd_east_m", kReal, true},      {"sd_north_m", kReal, true},
    {"sd_up_m", kReal, true},        {"sd_length_m", kReal, true},
    {"sd_width_m", kReal, true},     {"sd_height_m", kReal, true},
    {"sd_heading_deg", kReal, true}, {"apex0_lon_deg", kReal, true},
    {"apex0_lat_deg", kReal, true},  {"apex0_h_m", kReal, true},
    {"apex1_lon_deg", kReal, true},  {"apex1_lat_deg", kReal, true},
    {"apex1_h_m", kReal, true},      {"apex2_lon_deg", kReal, true},
    {"apex2_lat_deg", kReal, true},  {"apex2_h_m", kReal, true},
    {"apex3_lon_deg", kReal, true},  {"apex3_lat_deg", kReal, true},
    {"apex3_h_m", kReal, true},      {"apex4_lon_deg", kReal, true},
    {"apex4_lat_deg", kReal, true},  {"apex4_h_m", kReal, true},
    {"apex5_lon_deg", kReal, true},  {"apex5_lat_deg", kReal, true},
    {"apex5_h_m", kReal, true},      {"apex6_lon_deg", kReal, true},
    {"apex6_lat_deg", kReal, true},  {"apex6_h_m", kReal, true},
    {"apex7_lon_deg", kReal, true},  {"apex7_lat_deg", kReal, true},
    {"apex7_h_m", kReal, true},
});

constexpr auto kBoxFields = Joined(std::to_array<Field>({{"object_uid", kText, true}}), kBoxFigures,
                                   // the pictures its textures came from
                                   std::to_array<Field>({{"evidence", kText, false}}));

constexpr auto kObjectHead = std::to_array<Field>({
    {"id", kText, true},  // the uid: the same through all revisions
    {"class", kText, true},
    {"class_probability", kReal, true},
    {"state", kText, true},
    {"existence_probability", kReal, true},
    {"survey", kText, true},
    {"robots", kText, true},  // comma between
});

constexpr auto kObjectTail = std::to_array<Field>({
    {"second_heading_deg", kReal, false},
    {"sides_seen", kText, true},  // blank between; the others are inferred
    {"voxels", kInteger, true},
    {"votes", kInteger, true},
    {"texture_uri", kText, false},
    {"last_absent", kTime, false},
    {"ended_by", kInteger, false},  // the revision that closed the row
    {"ended_as", kText, false},     // and its state; "gone": nothing came after
    {"outline_id", kText, true},    // its kp_vector
    {"covariance", kText, true},    // upper triangle row by row, blank between (ChangedObject)
    // The columns of time to the nanosecond, POSIX UTC.
    {"begin_ns", kInteger, true},
    {"end_ns", kInteger, false},
    {"last_absent_ns", kInteger, false},
    {"first_seen_ns", kInteger, true},
    {"last_seen_ns", kInteger, true},
    {"gone_ns", kInteger, false},
});

constexpr auto kObjectFields = Joined(kObjectHead, kBoxFigures, kObjectTail);

constexpr auto kStationFields = std::to_array<Field>({
    {"id", kText, true},
    {"road", kText, true},
    {"survey", kText, true},
    {"along_m", kReal, true},
    {"t_begin", kTime, true},
    {"t_end", kTime, false},
    {"road_width_m", kReal, true},
    {"passable_m", kReal, true},
    {"passable_sd_m", kReal, true},
    {"gap_begin_m", kReal, true},
    {"gap_end_m", kReal, true},
    {"unknown_share", kReal, true},
    {"passable_class", kInteger, true},
    {"observed", kTime, false},
    {"begin_ns", kInteger, true},
    {"end_ns", kInteger, false},
    {"observed_ns", kInteger, false},
    {"element_id", kText, true},  // its kp_connector
});

constexpr auto kSchema = std::to_array<LayerSchema>({
    {kFeatureSpaceTable, "KIWI+ feature spaces", GeometryKind::kNone, kFeatureSpaceFields,
     "class_code", "", ""},
    {kVectorTable, "KIWI+ vectors", GeometryKind::kLineString, kVectorFields, "id", "",
     "class_code"},
    {kConnectorTable, "KIWI+ connectors", GeometryKind::kPoint, kConnectorFields, "id", "",
     "object_uid"},
    {kAttributeTable, "KIWI+ attributes of connectors", GeometryKind::kNone, kAttributeFields,
     "connector_id, key, value", "", ""},
    {kModelTable, "Textured models (2nd update)", GeometryKind::kPolygonZ, kModelFields, "uri", "",
     ""},
    {kBoxTable, "Boxes of changed objects, eight apexes each", GeometryKind::kPolygonZ, kBoxFields,
     "object_uid, revision", "revision", ""},
    {kTextureTable, "Textures of their sides", GeometryKind::kNone, kTextureFields,
     "object_uid, revision, face", "revision", ""},
    {kBoundsTable, "Bounds of begin and end of existence", GeometryKind::kNone, kBoundsFields,
     "element_id", "", ""},
    {kTxTable, "When this store was told", GeometryKind::kNone, kTxFields, "element_id", "", ""},
    {kMetaTable, "Datum, heights, times of the KIWI+ tables", GeometryKind::kNone, kMetaFields,
     "key", "", ""},
    {kChangedObject, "Changed objects (3rd update)", GeometryKind::kMultiPolygonZ, kObjectFields,
     "id, revision", "revision", "begin_ns"},
    {kRoadStation, "Road left to pass (3rd update)", GeometryKind::kLineStringZ, kStationFields,
     "id, begin_ns", "begin_ns", "road, along_m"},
});

}  // namespace

std::span<const LayerSchema> KiwiSchema() { return kSchema; }

}  // namespace kawara::gis
