#pragma once
#include <cstddef>
#include <variant>

#include "core/time.hpp"
#include "gis/records.hpp"

namespace kawara::station {

/// A record on its way into the store.
struct Item {
  std::variant<gis::PoseRecord, gis::PanoramaRecord, gis::EventRecord> record;
  core::MonoTime received;  ///< on this machine's clock; for latency only, never stored

  const gis::PanoramaRecord* picture() const { return std::get_if<gis::PanoramaRecord>(&record); }
  std::size_t bytes() const {
    const gis::PanoramaRecord* p = picture();
    return sizeof(Item) + 256 + (p != nullptr && p->jpeg ? p->jpeg->size() : 0);
  }
};

}  // namespace kawara::station
