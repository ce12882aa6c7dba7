#pragma once
#include <optional>
#include <string>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"

class OGRFeature;

/// Rows of changed_object, kp_box and road_station. Inside gis/kiwi only.
namespace kawara::gis {

/// What a row says beyond its record.
struct RowFrame {
  core::UtcTime begin;
  std::string survey;
  std::string texture_uri;  ///< empty: none
  std::string evidence;     ///< sources of the textures; empty: none
  std::string outline_id;
};

/// All but t_end; the feature must have the layer's definition.
void FillObject(OGRFeature& feature, const core::ChangedObject& object, const core::LocalEnu& map,
                const RowFrame& frame);
void FillBox(OGRFeature& feature, const core::ChangedObject& object, const core::LocalEnu& map,
             const RowFrame& frame);
void FillStation(OGRFeature& feature, const core::RoadStation& station, const core::LocalEnu& map,
                 const RowFrame& frame, const std::string& element_id);

/// A row of changed_object back in a map's frame, which may have another origin than the one it was
/// written from. kFormat: a hand has been at the row.
core::Expected<core::ChangedObject> ReadObject(const OGRFeature& row, const core::LocalEnu& map);

}  // namespace kawara::gis
