#include "gis/city/city_json.hpp"

#include <cpl_json.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>

#include "gis/gdal_errors.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;

constexpr int kDeepestBoundaries = 8;
constexpr double kHighestLod = 3.99;

class Reader {
 public:
  Reader(std::string name, const MapFrame& frame) : name_(std::move(name)), frame_(frame) {}

  core::Expected<CityObjects> Read(const CPLJSONObject& root) {
    if (root.GetString("type") != "CityJSON")
      return Wrong("no CityJSON (its type is \"" + root.GetString("type") + "\")");
    if (auto read = ReadVertices(root); !read) return tl::unexpected(read.error());
    const CPLJSONObject objects = root.GetObj("CityObjects");
    if (!objects.IsValid() || objects.GetType() != CPLJSONObject::Type::Object)
      return Wrong("no CityObjects");
    for (const CPLJSONObject& object : objects.GetChildren()) {
      const std::string type = object.GetString("type");
      if (type != "Building" && type != "BuildingPart") continue;
      if (auto taken = TakeObject(object); !taken) return tl::unexpected(taken.error());
    }
    return std::move(result_);
  }

 private:
  tl::unexpected<core::Error> Wrong(const std::string& what) const {
    return core::Fail(core::ErrorCode::kFormat, name_ + ": " + what);
  }

  static std::string ReferenceSystem(const CPLJSONObject& root) {
    const CPLJSONObject metadata = root.GetObj("metadata");
    if (!metadata.IsValid()) return "";
    return metadata.GetString("referenceSystem");
  }

  core::Expected<void> ReadVertices(const CPLJSONObject& root) {
    auto axes = CityAxes::Make(ReferenceSystem(root), frame_);
    if (!axes) return core::Fail(axes.error().code, name_ + ": " + axes.error().message);
    result_.heights = axes->heights();
    Vector3d scale = Vector3d::Ones(), translate = Vector3d::Zero();
    if (const CPLJSONObject transform = root.GetObj("transform"); transform.IsValid()) {
      if (!ReadTriple(transform.GetArray("scale"), scale) ||
          !ReadTriple(transform.GetArray("translate"), translate))
        return Wrong("its transform has no scale and translate of three numbers");
    }
    const CPLJSONArray vertices = root.GetArray("vertices");
    if (!vertices.IsValid()) return Wrong("no vertices");
    vertices_m_.reserve(static_cast<std::size_t>(vertices.Size()));
    for (int i = 0; i < vertices.Size(); ++i) {
      Vector3d v;
      if (!ReadTriple(vertices[i].ToArray(), v))
        return Wrong("vertex " + std::to_string(i) + " is not three numbers");
      vertices_m_.push_back(axes->Place(v.cwiseProduct(scale) + translate));
    }
    return {};
  }

  static bool ReadTriple(const CPLJSONArray& array, Vector3d& v) {
    if (!array.IsValid() || array.Size() != 3) return false;
    for (int k = 0; k < 3; ++k) {
      const CPLJSONObject number = array[k];
      if (!IsNumber(number)) return false;
      v[k] = number.ToDouble();
    }
    return v.allFinite();
  }
  static bool IsNumber(const CPLJSONObject& value) {
    const auto type = value.GetType();
    return type == CPLJSONObject::Type::Integer || type == CPLJSONObject::Type::Long ||
           type == CPLJSONObject::Type::Double;
  }
  /// "2.2", 2.2 or 2.
  static double LodOf(const CPLJSONObject& geometry) {
    const CPLJSONObject lod = geometry.GetObj("lod");
    if (!lod.IsValid()) return 0.0;
    if (IsNumber(lod)) return lod.ToDouble();
    const std::string text = lod.ToString();
    double value = 0.0;
    (void)std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  }

  core::Expected<void> TakeObject(const CPLJSONObject& json) {
    CityObject object;
    object.name = json.GetName();
    CPLJSONObject best;
    double best_lod = -1.0;
    if (const CPLJSONArray geometries = json.GetArray("geometry"); geometries.IsValid()) {
      for (int i = 0; i < geometries.Size(); ++i) {
        const CPLJSONObject geometry = geometries[i];
        const double lod = LodOf(geometry);
        if (lod < 1.0 || lod > kHighestLod || lod <= best_lod ||
            !geometry.GetArray("boundaries").IsValid() ||
            geometry.GetString("type") == "GeometryInstance")
          continue;
        best = geometry;
        best_lod = lod;
      }
    }
    if (best_lod < 0.0) {
      ++result_.passed_over;
      return {};
    }
    object.lod = static_cast<int>(best_lod);
    if (!TakeBoundaries(best.GetArray("boundaries"), object.surfaces, 0))
      return Wrong("CityObject " + object.name + ": boundaries that are no surfaces of vertices");
    TakeAttributes(json.GetObj("attributes"), object);
    result_.objects.push_back(std::move(object));
    return {};
  }

  static void TakeAttributes(const CPLJSONObject& attributes, CityObject& object) {
    if (!attributes.IsValid()) return;
    if (const std::string name = attributes.GetString("name"); !name.empty()) object.name = name;
    for (const char* key : {"surveyYear", "surveyDate", "creationDate"}) {
      const CPLJSONObject value = attributes.GetObj(key);
      if (value.IsValid() && !object.date) object.date = DateOf(value.ToString());
    }
    const CPLJSONObject sigma = attributes.GetObj("sigma_m");
    if (sigma.IsValid() && IsNumber(sigma) && sigma.ToDouble() > 0.0)
      object.sigma_m = sigma.ToDouble();
  }

  /// Shells, solids and what else wraps surfaces are gone through; a surface is a list of rings.
  bool TakeBoundaries(const CPLJSONArray& node, std::vector<CitySurface>& surfaces, int depth) {
    if (!node.IsValid() || depth > kDeepestBoundaries) return false;
    if (node.Size() == 0) return true;
    const CPLJSONArray first = node[0].ToArray();
    if (first.IsValid() && first.Size() > 0 && IsNumber(first[0])) {
      CitySurface surface;
      for (int i = 0; i < node.Size(); ++i) {
        std::vector<Vector3d> ring;
        if (!TakeRing(node[i].ToArray(), ring)) return false;
        if (i == 0) {
          surface.outer_m = std::move(ring);
        } else {
          surface.holes_m.push_back(std::move(ring));
        }
      }
      surfaces.push_back(std::move(surface));
      return true;
    }
    for (int i = 0; i < node.Size(); ++i)
      if (!TakeBoundaries(node[i].ToArray(), surfaces, depth + 1)) return false;
    return true;
  }
  bool TakeRing(const CPLJSONArray& json, std::vector<Vector3d>& ring) const {
    if (!json.IsValid()) return false;
    for (int i = 0; i < json.Size(); ++i) {
      if (!IsNumber(json[i])) return false;
      const GInt64 index = json[i].ToLong(-1);
      if (index < 0 || static_cast<std::size_t>(index) >= vertices_m_.size()) return false;
      ring.push_back(vertices_m_[static_cast<std::size_t>(index)]);
    }
    return true;
  }

  const std::string name_;
  const MapFrame& frame_;
  std::vector<Vector3d> vertices_m_;
  CityObjects result_;
};

}  // namespace

core::Expected<CityObjects> ParseCityJson(const std::string& text, const std::string& name,
                                          const MapFrame& frame) {
  const GdalErrorCatcher errors;
  CPLJSONDocument document;
  if (!document.LoadMemory(text))
    return core::Fail(core::ErrorCode::kFormat, name + ": no whole JSON: " + errors.message());
  return Reader(name, frame).Read(document.GetRoot());
}

core::Expected<CityObjects> ReadCityJson(const std::string& path, const MapFrame& frame) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return tl::unexpected(core::ErrnoError(path, errno == 0 ? EIO : errno));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return ParseCityJson(text, path, frame);
}

bool IsCityJson(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(4096, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  const std::size_t begin = head.find_first_not_of(" \t\r\n");
  return begin != std::string::npos && head[begin] == '{' &&
         (head.find("\"CityJSON\"") != std::string::npos || path.ends_with(".city.json"));
}

}  // namespace kawara::gis
