#include "gis/kiwi/kiwi_tables.hpp"

#include <ogrsf_frmts.h>

#include <memory>

#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/kiwi/row_fields.hpp"

namespace kawara::gis {
namespace {

/// What vectors and connectors have in common.
template <class Element>
void FillElement(OGRFeature& f, const Element& element) {
  SetTextAlways(f, "id", element.id);
  SetTextAlways(f, "class_code", element.class_code);
  SetInteger(f, "flags", element.flags);
  SetReal(f, "base_elev_m", element.height.base_elev_m);
  SetReal(f, "rel_height_m", element.height.rel_height_m);
  SetTime(f, "t_begin", element.begin);
}

std::string TimeOrNull(core::UtcTime t) { return t.IsSet() ? SqlText(IsoUtc(t)) : "NULL"; }

}  // namespace

core::Expected<OGRLayer*> KiwiTables::LayerOf(const char* table) {
  OGRLayer* layer = dataset_.Layer(table);
  if (layer == nullptr)
    return core::Fail(core::ErrorCode::kIo, std::string("the store has lost its layer ") + table);
  return layer;
}

core::Expected<void> KiwiTables::Write(const FeatureSpace& space) {
  const auto there =
      dataset_.QueryInteger(std::string("SELECT count(*) AS n FROM ") + kFeatureSpaceTable +
                            " WHERE class_code = " + SqlText(space.class_code));
  if (!there) return tl::unexpected(there.error());
  if (there->value_or(0) > 0) return {};
  const auto layer = LayerOf(kFeatureSpaceTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  SetTextAlways(f, "class_code", space.class_code);
  SetTextAlways(f, "name", space.name);
  SetTextAlways(f, "dim", space.dim);
  SetText(f, "parent", space.parent);
  return dataset_.Write(**layer, f);
}

core::Expected<void> KiwiTables::Write(const VectorElement& vector) {
  const auto layer = LayerOf(kVectorTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  FillElement(f, vector);
  auto line = std::make_unique<OGRLineString>();
  for (const LonLat& p : vector.line) line->addPoint(p.lon_deg, p.lat_deg);
  f.SetGeometryDirectly(line.release());
  touched_.insert(kVectorTable);
  auto written = dataset_.Write(**layer, f);
  return written ? WriteTold(vector.id) : written;
}

core::Expected<void> KiwiTables::Write(const ConnectorElement& connector) {
  const auto layer = LayerOf(kConnectorTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  FillElement(f, connector);
  SetTextAlways(f, "object_uid", connector.object_uid);
  f.SetGeometryDirectly(
      std::make_unique<OGRPoint>(connector.place.lon_deg, connector.place.lat_deg).release());
  touched_.insert(kConnectorTable);
  auto written = dataset_.Write(**layer, f);
  return written ? WriteTold(connector.id) : written;
}

core::Expected<void> KiwiTables::Write(const Attribute& attribute) {
  const auto layer = LayerOf(kAttributeTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  SetTextAlways(f, "connector_id", attribute.connector_id);
  SetTextAlways(f, "key", attribute.key);
  SetTextAlways(f, "value", attribute.value);
  SetText(f, "unit", attribute.unit);
  return dataset_.Write(**layer, f);
}

core::Expected<void> KiwiTables::Close(ElementKind kind, const std::string& id, core::UtcTime end) {
  const std::string table = kind == ElementKind::kVector ? kVectorTable : kConnectorTable;
  auto closed = dataset_.Execute("UPDATE " + table + " SET t_end = " + SqlText(IsoUtc(end)) +
                                 " WHERE id = " + SqlText(id) + " AND t_end IS NULL");
  if (!closed || !told_.at.IsSet()) return closed;
  return dataset_.Execute(std::string("UPDATE ") + kTxTable +
                          " SET tx_end = " + SqlText(IsoUtc(told_.at)) +
                          " WHERE element_id = " + SqlText(id) + " AND tx_end IS NULL");
}

core::Expected<void> KiwiTables::WriteTold(const std::string& element_id) {
  if (!told_.at.IsSet()) return {};
  const auto layer = LayerOf(kTxTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  SetTextAlways(f, "element_id", element_id);
  SetTime(f, "tx_begin", told_.at);
  SetTextAlways(f, "who", told_.who);
  return dataset_.Write(**layer, f);
}

core::Expected<void> KiwiTables::WriteBounds(const std::string& element_id,
                                             const ExistenceBounds& bounds) {
  const auto layer = LayerOf(kBoundsTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  SetTextAlways(f, "element_id", element_id);
  SetTime(f, "begin_min", bounds.begin_min);
  SetTime(f, "begin_max", bounds.begin_max);
  return dataset_.Write(**layer, f);
}

core::Expected<void> KiwiTables::CloseBounds(const std::string& element_id, core::UtcTime end_min,
                                             core::UtcTime end_max) {
  return dataset_.Execute(std::string("UPDATE ") + kBoundsTable + " SET end_min = " +
                          TimeOrNull(end_min) + ", end_max = " + TimeOrNull(end_max) +
                          " WHERE element_id = " + SqlText(element_id) + " AND end_max IS NULL");
}

core::Expected<void> KiwiTables::WriteMeta(const std::string& key, const std::string& value) {
  const auto there = dataset_.QueryInteger(std::string("SELECT count(*) AS n FROM ") + kMetaTable +
                                           " WHERE key = " + SqlText(key));
  if (!there) return tl::unexpected(there.error());
  if (there->value_or(0) > 0) return {};
  const auto layer = LayerOf(kMetaTable);
  if (!layer) return tl::unexpected(layer.error());
  OGRFeature f((*layer)->GetLayerDefn());
  SetTextAlways(f, "key", key);
  SetTextAlways(f, "value", value);
  return dataset_.Write(**layer, f);
}

core::Expected<void> KiwiTables::Finish() {
  for (const char* table : touched_) {
    const auto layer = LayerOf(table);
    if (!layer) return tl::unexpected(layer.error());
    if (auto synced = dataset_.Sync(**layer, "t_begin"); !synced) return synced;
  }
  touched_.clear();
  return {};
}

}  // namespace kawara::gis
