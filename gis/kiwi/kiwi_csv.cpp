#include "gis/kiwi/kiwi_csv.hpp"

#include "core/iso8601.hpp"
#include "gis/kiwi/export_text.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {
namespace {

constexpr const char* kNewLine = "\r\n";

std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

std::string Line(const std::vector<std::string>& cells) {
  std::string line;
  for (const std::string& cell : cells) line.append(line.empty() ? "" : ",").append(Cell(cell));
  return line;
}

std::string Wkt(const LonLat& p) {
  return Number(p.lon_deg, kDegreeDecimals) + " " + Number(p.lat_deg, kDegreeDecimals);
}

template <class Element>
std::string Head(const Element& e, const std::string& wkt) {
  return Line({e.id, e.class_code, std::to_string(e.flags), wkt,
               Number(e.height.base_elev_m, kHeightDecimals),
               Number(e.height.rel_height_m, kHeightDecimals), core::FormatIso8601(e.begin)});
}

}  // namespace

core::Expected<void> KiwiCsv::Write(const FeatureSpace& space) {
  spaces_ += Line({space.class_code, space.name, space.dim, space.parent}) + kNewLine;
  return {};
}

core::Expected<void> KiwiCsv::Write(const VectorElement& vector) {
  std::string wkt;
  for (const LonLat& p : vector.line) wkt.append(wkt.empty() ? "" : ", ").append(Wkt(p));
  vectors_.by_id[vector.id] = vectors_.rows.size();
  vectors_.rows.push_back({Head(vector, "LINESTRING (" + wkt + ")"), "", ""});
  return {};
}

core::Expected<void> KiwiCsv::Write(const ConnectorElement& connector) {
  connectors_.by_id[connector.id] = connectors_.rows.size();
  connectors_.rows.push_back({Head(connector, "POINT (" + Wkt(connector.place) + ")"), "",
                              "," + Cell(connector.object_uid)});
  return {};
}

core::Expected<void> KiwiCsv::Write(const Attribute& attribute) {
  attributes_ +=
      Line({attribute.connector_id, attribute.key, attribute.value, attribute.unit}) + kNewLine;
  return {};
}

core::Expected<void> KiwiCsv::Close(ElementKind kind, const std::string& id, core::UtcTime end) {
  Table& table = kind == ElementKind::kVector ? vectors_ : connectors_;
  const auto found = table.by_id.find(id);
  if (found == table.by_id.end())
    return core::Fail(core::ErrorCode::kInvalidArgument, "close " + id + ": no such element");
  Row& row = table.rows[found->second];
  if (row.end.empty()) row.end = core::FormatIso8601(end);
  return {};
}

core::Expected<void> KiwiCsv::Finish() const {
  const std::string element = "id,class_code,flags,geom,base_elev_m,rel_height_m,t_begin,t_end";
  const auto text = [](const std::string& header, const Table& table) {
    std::string all = header + kNewLine;
    for (const Row& row : table.rows) all += row.head + "," + row.end + row.tail + kNewLine;
    return all;
  };
  auto done = WriteWholeFile(folder_ / "feature_space.csv",
                             std::string("class_code,name,dim,parent") + kNewLine + spaces_);
  if (done) done = WriteWholeFile(folder_ / "vector.csv", text(element, vectors_));
  if (done)
    done = WriteWholeFile(folder_ / "connector.csv", text(element + ",object_uid", connectors_));
  if (done)
    done = WriteWholeFile(folder_ / "attribute.csv",
                          std::string("connector_id,key,value,unit") + kNewLine + attributes_);
  return done;
}

}  // namespace kawara::gis
