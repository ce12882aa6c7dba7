#pragma once
#include <span>
#include <string>

#include "core/expected.hpp"
#include "gis/ogr_dataset.hpp"
#include "gis/schema.hpp"

/// Bringing a store into being. Inside gis/ only.
namespace kawara::gis {

/// Opens the store for writing; makes it first if it is not there: a GeoPackage under a temporary
/// name that is renamed when it is complete (so that no kill leaves half a schema), PostGIS tables
/// in one transaction. Missing layers are added to an existing file or database; layers of the same
/// name but another shape are refused.
core::Expected<OgrDataset> OpenStore(const std::string& target);

/// The QGIS style of a layer: symbol, and temporal mode on t_begin/t_end.
std::string QmlStyle(const std::string& layer);
/// `symbology` (renderer, tips; may be empty) within the frame of a QGIS style that shows rows from
/// t_begin to t_end.
std::string QmlWithTime(const std::string& symbology);

/// The same for another set of layers in the same file or database. `style` answers with the QML of
/// a layer, empty: none.
core::Expected<OgrDataset> OpenStore(const std::string& target, std::span<const LayerSchema> layers,
                                     std::string (*style)(const std::string& layer));

}  // namespace kawara::gis
