#include "gis/kiwi/elements.hpp"

#include <array>

#include "gis/kiwi/kiwi_plus_writer.hpp"

namespace kawara::gis {

std::span<const FeatureSpace> FeatureSpaces() {
  static const std::array<FeatureSpace, 15> kSpaces{{
      {"base", "What stands on the map", "area", ""},
      {"base.building", "Building", "volume", "base"},
      {"base.road", "Road", "area", "base"},
      {"obs", "What a robot took", "point", ""},
      {"obs.pose", "Pose of a robot", "point", "obs"},
      {"obs.panorama", "Omnidirectional picture", "point", "obs"},
      {"obs.trajectory", "Track of a robot", "trajectory", "obs"},
      {"model", "Model made of pictures", "volume", ""},
      {kClassModel, "Textured model, 2nd update", "volume", "model"},
      {"change", "What differs from the map", "volume", ""},
      {"change.region", "Region that differs", "area", "change"},
      {kClassBox, "Box of a changed object, 3rd update", "volume", "change"},
      {kClassBoxOutline, "Outline of such a box", "line", kClassBox},
      {kClassRoadWidth, "Width of road left to pass", "line", ""},
      {kClassRoadBlocked, "Place where nothing passes", "line", kClassRoadWidth},
  }};
  return kSpaces;
}

core::Expected<void> KiwiPlusWriter::Write(const ElementSet& set) {
  core::Expected<void> done;
  for (const VectorElement& vector : set.vectors) {
    if (done) done = Write(vector);
  }
  if (done) done = Write(set.connector);
  for (const Attribute& attribute : set.attributes) {
    if (done) done = Write(attribute);
  }
  return done;
}

}  // namespace kawara::gis
