#include <ogrsf_frmts.h>

#include "gis/kiwi/kiwi_csv.hpp"
#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/kiwi/row_fields.hpp"
#include "gis/ogr_dataset.hpp"

namespace kawara::gis {
namespace {

core::UtcTime TimeOf(const OGRFeature& row, const char* name) {
  if (IsNull(row, name)) return {};
  core::CivilTime c;
  int zone = 0;
  float second = 0.0F;
  row.GetFieldAsDateTime(row.GetFieldIndex(name), &c.year, &c.month, &c.day, &c.hour, &c.minute,
                         &second, &zone);
  // A float of seconds holds milliseconds and no more.
  const auto ms = std::lround(static_cast<double>(second) * 1e3);
  return core::FromCivil(c) + core::Milliseconds(ms);
}

template <class Element>
void ReadElement(const OGRFeature& row, Element& element) {
  element.id = row.GetFieldAsString("id");
  element.class_code = row.GetFieldAsString("class_code");
  element.flags = static_cast<std::uint32_t>(row.GetFieldAsInteger64("flags"));
  element.height = {row.GetFieldAsDouble("base_elev_m"), row.GetFieldAsDouble("rel_height_m")};
  element.begin = TimeOf(row, "t_begin");
}

VectorElement ReadVector(const OGRFeature& row) {
  VectorElement vector;
  ReadElement(row, vector);
  if (const OGRGeometry* geometry = row.GetGeometryRef();
      geometry != nullptr && wkbFlatten(geometry->getGeometryType()) == wkbLineString) {
    for (const OGRPoint& p : *geometry->toLineString()) vector.line.push_back({p.getX(), p.getY()});
  }
  return vector;
}

ConnectorElement ReadConnector(const OGRFeature& row) {
  ConnectorElement connector;
  ReadElement(row, connector);
  connector.object_uid = row.GetFieldAsString("object_uid");
  if (const OGRGeometry* geometry = row.GetGeometryRef();
      geometry != nullptr && wkbFlatten(geometry->getGeometryType()) == wkbPoint)
    connector.place = {geometry->toPoint()->getX(), geometry->toPoint()->getY()};
  return connector;
}

/// Calls `write(row)` for every row in the order they were written.
template <class WriteRow>
core::Expected<void> EachRow(OgrDataset& dataset, const char* table, WriteRow&& write) {
  core::Expected<void> written;
  auto read = dataset.ForEach(std::string("SELECT * FROM ") + table + " ORDER BY fid",
                              [&](const OGRFeature& row) {
                                if (written) written = write(row);
                              });
  return read ? written : read;
}

}  // namespace

core::Expected<void> ReplayKiwiPlus(const std::string& target, KiwiPlusWriter& writer) {
  auto dataset = OgrDataset::Open(target, true);
  if (!dataset) return tl::unexpected(dataset.error());
  for (const char* table : {kFeatureSpaceTable, kVectorTable, kConnectorTable, kAttributeTable}) {
    if (dataset->Layer(table) == nullptr)
      return core::Fail(core::ErrorCode::kFormat,
                        target + ": has no table " + table + ": nothing was registered in it");
  }
  auto done = EachRow(*dataset, kFeatureSpaceTable, [&writer](const OGRFeature& row) {
    return writer.Write(FeatureSpace{row.GetFieldAsString("class_code"),
                                     row.GetFieldAsString("name"), row.GetFieldAsString("dim"),
                                     row.GetFieldAsString("parent")});
  });
  const auto close_if_ended = [&writer](ElementKind kind, const std::string& id,
                                        core::UtcTime end) -> core::Expected<void> {
    if (!end.IsSet()) return {};
    return writer.Close(kind, id, end);
  };
  if (done)
    done = EachRow(*dataset, kVectorTable, [&](const OGRFeature& row) {
      const VectorElement vector = ReadVector(row);
      auto written = writer.Write(vector);
      return written ? close_if_ended(ElementKind::kVector, vector.id, TimeOf(row, "t_end"))
                     : written;
    });
  if (done)
    done = EachRow(*dataset, kConnectorTable, [&](const OGRFeature& row) {
      const ConnectorElement connector = ReadConnector(row);
      auto written = writer.Write(connector);
      return written ? close_if_ended(ElementKind::kConnector, connector.id, TimeOf(row, "t_end"))
                     : written;
    });
  if (done)
    done = EachRow(*dataset, kAttributeTable, [&writer](const OGRFeature& row) {
      return writer.Write(Attribute{row.GetFieldAsString("connector_id"),
                                    row.GetFieldAsString("key"), row.GetFieldAsString("value"),
                                    row.GetFieldAsString("unit")});
    });
  return done;
}

}  // namespace kawara::gis
