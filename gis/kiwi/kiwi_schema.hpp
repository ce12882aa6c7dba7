#pragma once
#include <span>
#include <string>

#include "gis/schema.hpp"

/// The tables of the open KIWI+ profile and two layers for people, as this project stores them
/// beside (in the same file or database as) the layers of gis/schema.hpp. Longitude and latitude
/// are EPSG:4326 in degrees, heights above the ellipsoid in metres, times UTC with milliseconds.
namespace kawara::gis {

inline constexpr const char* kFeatureSpaceTable = "kp_feature_space";
inline constexpr const char* kVectorTable = "kp_vector";
inline constexpr const char* kConnectorTable = "kp_connector";
inline constexpr const char* kAttributeTable = "kp_attribute";
inline constexpr const char* kModelTable = "kp_model";
inline constexpr const char* kBoxTable = "kp_box";
inline constexpr const char* kTextureTable = "kp_texture";
inline constexpr const char* kBoundsTable = "kp_t_bounds";
inline constexpr const char* kTxTable = "kp_tx";
inline constexpr const char* kMetaTable = "kp_meta";
/// One row a revision of a changed object, with all that core::ChangedObject holds.
inline constexpr const char* kChangedObject = "changed_object";
/// One row an observation of a place along the road, as core::RoadStation.
inline constexpr const char* kRoadStation = "road_station";

/// All of them. kp_trajectory and kp_pose of the profile are the layers trajectory and obs_pose of
/// the store (gis/schema.hpp), which hold the same.
std::span<const LayerSchema> KiwiSchema();
/// Their QGIS styles, time slider on; empty: none.
std::string KiwiStyle(const std::string& layer);

}  // namespace kawara::gis
