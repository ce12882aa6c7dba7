#pragma once
#include <cstddef>
#include <variant>

#include "comms/object_message.hpp"
#include "comms/road_message.hpp"
#include "comms/texture_message.hpp"
#include "core/time.hpp"
#include "gis/records.hpp"

namespace kawara::station {

/// A record on its way into the store.
struct Item {
  std::variant<gis::PoseRecord, gis::PanoramaRecord, gis::EventRecord, comms::ObjectReport,
               comms::TextureReport, comms::RoadReport>
      record;
  core::MonoTime received;  ///< on this machine's clock; for latency only, never stored

  const gis::PanoramaRecord* picture() const { return std::get_if<gis::PanoramaRecord>(&record); }
  /// For the register of changed objects, not for the store of poses and pictures.
  bool is_of_objects() const {
    return std::holds_alternative<comms::ObjectReport>(record) ||
           std::holds_alternative<comms::TextureReport>(record) ||
           std::holds_alternative<comms::RoadReport>(record);
  }
  std::size_t bytes() const {
    std::size_t more = 256;
    if (const gis::PanoramaRecord* p = picture(); p != nullptr && p->jpeg) more += p->jpeg->size();
    if (const auto* texture = std::get_if<comms::TextureReport>(&record))
      more += texture->textures.atlas_jpeg.size();
    if (const auto* road = std::get_if<comms::RoadReport>(&record))
      more += road->stations.size() * sizeof(core::RoadStation);
    return sizeof(Item) + more;
  }
};

}  // namespace kawara::station
