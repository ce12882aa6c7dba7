#include "sim/site/truth_objects.hpp"

#include <cmath>

#include "sim/site/solid_builder.hpp"
#include "sim/site/text_file.hpp"

namespace kawara::sim {
namespace {

/// 0 to 360.
double HeadingDeg(double heading_rad) {
  const double deg = core::WrapPi(heading_rad) * core::kDegFromRad;
  return deg < 0 ? deg + 360.0 : deg;
}

}  // namespace

std::array<Eigen::Vector3d, 8> Apexes(const UprightBox& box) {
  const Frame frame = StandingFrame(box.centre_enu_m.x(), box.centre_enu_m.y(),
                                    box.centre_enu_m.z(), box.heading_rad);
  const Eigen::Vector3d half = box.size_m / 2.0;
  constexpr std::array<std::array<double, 2>, 4> kCorners{{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  std::array<Eigen::Vector3d, 8> apexes;
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign(kCorners[i % 4][0], kCorners[i % 4][1], i < 4 ? -1.0 : 1.0);
    apexes[i] = frame * Eigen::Vector3d(half.cwiseProduct(sign));
  }
  return apexes;
}

UprightBox VisibleBox(const SceneObject& object) {
  UprightBox box = object.box;
  box.size_m.z() -= object.buried_m;
  box.centre_enu_m.z() += object.buried_m / 2.0;
  return box;
}

const char* NameOf(ObjectClass cls) {
  switch (cls) {
    case ObjectClass::kGround:
      return "ground";
    case ObjectClass::kBuilding:
      return "building";
    case ObjectClass::kPole:
      return "pole";
    case ObjectClass::kFence:
      return "fence";
    case ObjectClass::kTree:
      return "tree";
    case ObjectClass::kKerb:
      return "kerb";
    case ObjectClass::kTruck:
      return "truck";
    case ObjectClass::kCar:
      return "car";
    case ObjectClass::kRubble:
      return "rubble";
    case ObjectClass::kPerson:
      return "person";
    case ObjectClass::kClutter:
      return "clutter";
  }
  return "unknown";
}

std::vector<SceneObject> StandingObjects(const Scene& scene) {
  std::vector<SceneObject> standing;
  for (const SceneObject& object : scene.objects)
    if (object.cls != ObjectClass::kGround && object.cls != ObjectClass::kKerb)
      standing.push_back(object);
  return standing;
}

core::Expected<void> WriteObjectsCsv(const Scene& scene, const std::string& path) {
  const core::LocalEnu enu(scene.origin);
  const auto position = [&enu](const Eigen::Vector3d& p_enu_m) {
    const core::Geodetic g = enu.ToGeodetic(p_enu_m);
    return "," + Fixed(g.lon_rad * core::kDegFromRad, 10) + "," +
           Fixed(g.lat_rad * core::kDegFromRad, 10) + "," + Fixed(g.h_ellipsoidal_m, 4);
  };
  std::string text =
      "id,name,class,in_reference,begin_s,end_s,centre_lon_deg,centre_lat_deg,centre_h_m,length_m,"
      "width_m,height_m,heading_deg";
  for (int i = 0; i < 8; ++i) {
    const std::string apex = ",apex" + std::to_string(i);
    text += apex + "_lon_deg" + apex + "_lat_deg" + apex + "_h_m";
  }
  text += "\n";
  for (const SceneObject& object : StandingObjects(scene)) {
    const UprightBox box = VisibleBox(object);
    text += std::to_string(object.id) + "," + CsvText(object.name) + "," + NameOf(object.cls) +
            (object.in_reference ? ",1," : ",0,");
    text += (object.begin_s ? Fixed(*object.begin_s, 3) : "") + ",";
    text += object.end_s ? Fixed(*object.end_s, 3) : "";
    text += position(box.centre_enu_m);
    for (const double side_m : box.size_m) text += "," + Fixed(side_m, 4);
    text += "," + Fixed(HeadingDeg(box.heading_rad), 4);
    for (const Eigen::Vector3d& apex : Apexes(box)) text += position(apex);
    text += "\n";
  }
  return WriteTextFile(path, text);
}

core::Expected<void> WriteObjectsGeoJson(const Scene& scene, const std::string& path) {
  const core::LocalEnu enu(scene.origin);
  std::string text = "{\"type\": \"FeatureCollection\", \"features\": [";
  const char* separator = "\n";
  for (const SceneObject& object : StandingObjects(scene)) {
    const UprightBox box = VisibleBox(object);
    const auto apexes = Apexes(box);
    text += separator;
    separator = ",\n";
    text += "{\"type\": \"Feature\", \"id\": " + std::to_string(object.id) +
            ", \"properties\": {\"name\": " + JsonText(object.name) + ", \"class\": \"" +
            NameOf(object.cls) +
            "\", \"in_reference\": " + (object.in_reference ? "true" : "false") +
            ", \"begin_s\": " + (object.begin_s ? Fixed(*object.begin_s, 3) : "null") +
            ", \"end_s\": " + (object.end_s ? Fixed(*object.end_s, 3) : "null") +
            ", \"height_m\": " + Fixed(box.size_m.z(), 4) +
            ", \"heading_deg\": " + Fixed(HeadingDeg(box.heading_rad), 4) +
            "}, \"geometry\": {\"type\": \"Polygon\", \"coordinates\": [[";
    for (const std::size_t i : {0U, 1U, 2U, 3U, 0U})
      text += (text.back() == '[' ? "" : ", ") + JsonPosition(enu.ToGeodetic(apexes[i]));
    text += "]]}}";
  }
  text += "\n]}\n";
  return WriteTextFile(path, text);
}

}  // namespace kawara::sim
