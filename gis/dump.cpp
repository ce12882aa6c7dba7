#include "gis/dump.hpp"

#include <ogrsf_frmts.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <tuple>
#include <vector>

#include "gis/ogr_dataset.hpp"

namespace kawara::gis {
namespace {

struct Line {
  std::string robot;
  std::string mission;
  std::int64_t order = 0;
  std::string text;
  bool operator<(const Line& o) const {
    return std::tie(robot, mission, order, text) < std::tie(o.robot, o.mission, o.order, o.text);
  }
};

std::string Digits(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.15g", value);
  return text.data();
}

std::string TimeText(const OGRFeature& f, int field) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, flag = 0;
  float second = 0.0F;
  f.GetFieldAsDateTime(field, &year, &month, &day, &hour, &minute, &second, &flag);
  const int ms = static_cast<int>(std::lround(second * 1000.0F));
  constexpr int kUtcFlag = 100;
  const int east_minutes = flag > 1 ? (flag - kUtcFlag) * 15 : 0;
  const core::UtcTime local = core::FromCivil({year, month, day, hour, minute, ms / 1000, 0});
  return IsoUtc(local + core::Milliseconds(ms % 1000) - std::chrono::minutes(east_minutes));
}

std::string ValueText(const OGRFeature& f, int i) {
  if (!f.IsFieldSetAndNotNull(i)) return "NULL";
  switch (f.GetFieldDefnRef(i)->GetType()) {
    case OFTReal:
      return Digits(f.GetFieldAsDouble(i));
    case OFTDateTime:
      return TimeText(f, i);
    default:
      return f.GetFieldAsString(i);
  }
}

std::string GeometryText(const OGRGeometry* geometry) {
  if (geometry == nullptr) return "NULL";
  const auto point = [](double x, double y, double z) {
    return Digits(x) + " " + Digits(y) + " " + Digits(z);
  };
  if (wkbFlatten(geometry->getGeometryType()) == wkbPoint) {
    const OGRPoint* p = geometry->toPoint();
    return "POINT Z (" + point(p->getX(), p->getY(), p->getZ()) + ")";
  }
  if (wkbFlatten(geometry->getGeometryType()) != wkbLineString) return "?";
  const OGRLineString* line = geometry->toLineString();
  std::string text = "LINESTRING ZM (";
  for (int i = 0; i < line->getNumPoints(); ++i)
    text += (i == 0 ? "" : ", ") + point(line->getX(i), line->getY(i), line->getZ(i)) + " " +
            Digits(line->getM(i));
  return text + ")";
}

/// " file=1234 bytes, crc32 0badcafe"; counts what is wrong.
std::string FileText(const std::filesystem::path& path, const std::string& expected_crc,
                     int& wrong) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    ++wrong;
    return "MISSING";
  }
  uLong crc = crc32_z(0, nullptr, 0);
  std::size_t bytes = 0;
  std::vector<char> chunk(1 << 16);
  while (file.read(chunk.data(), static_cast<std::streamsize>(chunk.size())), file.gcount() > 0) {
    const auto n = static_cast<std::size_t>(file.gcount());
    const std::vector<Bytef> data(chunk.begin(), chunk.begin() + file.gcount());
    crc = crc32_z(crc, data.data(), n);
    bytes += n;
  }
  std::array<char, 16> hex{};
  std::snprintf(hex.data(), hex.size(), "%08lx", crc);
  std::string text = std::to_string(bytes) + " bytes, crc32 " + hex.data();
  if (!expected_crc.empty() && expected_crc != hex.data()) {
    ++wrong;
    text += " BUT THE ROW SAYS " + expected_crc;
  }
  return text;
}

}  // namespace

core::Expected<void> DumpStore(const std::string& target, const std::filesystem::path& pictures_dir,
                               std::ostream& out) {
  namespace fs = std::filesystem;
  auto dataset = OgrDataset::Open(target, true);
  if (!dataset) return tl::unexpected(dataset.error());
  // A uri is relative to the folder that holds the store (PostGIS: that holds the picture folder).
  fs::path home = fs::absolute(target).parent_path();
  if (dataset->is_postgis())
    home = pictures_dir.empty() ? fs::current_path() : fs::absolute(pictures_dir).parent_path();
  int wrong = 0;
  for (const LayerSchema& schema : Schema()) {
    std::vector<Line> lines;
    auto read =
        dataset->ForEach(std::string("SELECT * FROM ") + schema.name, [&](const OGRFeature& f) {
          Line line;
          line.text = schema.name;
          const auto at = [&f](const char* name) { return f.GetFieldIndex(name); };
          for (const Field& field : schema.fields) {
            const int i = at(field.name);
            const std::string value = i < 0 ? "?" : ValueText(f, i);
            line.text += std::string("\t") + field.name + "=" + value;
            if (i >= 0 && std::string(field.name) == schema.order_key)
              line.order = f.GetFieldAsInteger64(i);
          }
          if (at("robot") >= 0) line.robot = f.GetFieldAsString(at("robot"));
          if (at("mission") >= 0) line.mission = f.GetFieldAsString(at("mission"));
          if (schema.geometry != GeometryKind::kNone)
            line.text += "\tgeom=" + GeometryText(f.GetGeometryRef());
          if (at("uri") >= 0) {
            line.text += "\tfile=" + FileText(home / f.GetFieldAsString(at("uri")),
                                              f.GetFieldAsString(at("crc32")), wrong);
            if (f.IsFieldSetAndNotNull(at("preview_uri")))
              line.text += "\tpreview_file=" +
                           FileText(home / f.GetFieldAsString(at("preview_uri")), "", wrong);
          }
          lines.push_back(std::move(line));
        });
    if (!read) return read;
    std::sort(lines.begin(), lines.end());
    out << "# " << schema.name << ": " << lines.size() << " rows\n";
    for (const Line& line : lines) out << line.text << '\n';
  }
  if (wrong > 0)
    return core::Fail(core::ErrorCode::kFormat,
                      std::to_string(wrong) + " pictures are missing or not what their rows say");
  return {};
}

}  // namespace kawara::gis
