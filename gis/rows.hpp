#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/records.hpp"

class OGRFeature;

/// Records to OGR features. Real numbers are rounded to fixed decimals far below their accuracy
/// (1e-10 deg, 0.1 mm, 1e-6 deg), so that every database and text format gives back the same
/// figure. Inside gis/ only.
namespace kawara::gis {

struct TrackVertex {
  std::int64_t gps_ns = 0;
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  double h_ellipsoidal_m = 0.0;
};

/// Where a panorama's files are, relative to the store's folder, and what the best one holds.
struct PictureFiles {
  std::string uri;
  std::string preview_uri;  ///< empty: there is none
};

core::UtcTime UtcOf(core::GpsTime t);

/// All but t_end and the FID. The feature must have the layer's definition.
void Fill(OGRFeature& feature, const PoseRecord& record);
void Fill(OGRFeature& feature, const PanoramaRecord& record, const PictureFiles& files);
void Fill(OGRFeature& feature, const EventRecord& record);
/// Vertices in time order, at least two.
void Fill(OGRFeature& feature, const std::string& robot, const std::string& mission,
          const std::vector<TrackVertex>& track);
/// Not set: an open end.
void SetEnd(OGRFeature& feature, core::GpsTime t_end);

/// The position of a pose as the store holds it.
TrackVertex VertexOf(const PoseFields& pose);

const char* ToString(PictureStage stage);

}  // namespace kawara::gis
