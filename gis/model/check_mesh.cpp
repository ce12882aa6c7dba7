#include <algorithm>
#include <cctype>
#include <cmath>

#include "gis/model/model_writers.hpp"

namespace kawara::gis {
namespace {

tl::unexpected<core::Error> Wrong(const core::TexturedMesh& mesh, const char* what) {
  return core::Fail(core::ErrorCode::kInvalidArgument, "mesh '" + mesh.name + "': " + what);
}

template <class Rows>
bool AllFinite(const Rows& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const auto& row) {
    return std::all_of(row.begin(), row.end(), [](float v) { return std::isfinite(v); });
  });
}

}  // namespace

core::Expected<void> CheckMesh(const core::TexturedMesh& mesh) {
  const bool good_name =
      !mesh.name.empty() && std::all_of(mesh.name.begin(), mesh.name.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '_' || c == '-';
      });
  if (!good_name) return Wrong(mesh, "its name must be letters, digits, '_' and '-'");
  const std::size_t n = mesh.positions_m.size();
  if (n > 0xFFFFFFF0U) return Wrong(mesh, "too many corners");
  const auto fits = [&](std::size_t size) { return size == 0 || size == n; };
  if (!fits(mesh.normals.size()) || !fits(mesh.colours.size()) ||
      !fits(mesh.texture_coordinates.size()))
    return Wrong(mesh, "normals, colours or texture coordinates are not one for each corner");
  if (!mesh.texture_jpeg.empty() && mesh.texture_coordinates.empty())
    return Wrong(mesh, "a texture without coordinates");
  if (!mesh.offset_m.allFinite() || !AllFinite(mesh.positions_m) || !AllFinite(mesh.normals) ||
      !AllFinite(mesh.texture_coordinates))
    return Wrong(mesh, "a number that is not finite");
  for (const auto& t : mesh.triangles)
    if (t[0] >= n || t[1] >= n || t[2] >= n) return Wrong(mesh, "a triangle of corners it has not");
  return {};
}

}  // namespace kawara::gis
