#pragma once
#include <cstdint>
#include <list>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/ogr_dataset.hpp"
#include "gis/rows.hpp"

namespace kawara::gis {

/// Keeps the layer trajectory in step with obs_pose: one line per robot and mission, derived and
/// never master, so it can be made again at any time. A line is written again when it has grown by
/// one vertex in 512 (each time while it is short), which keeps the cost of a growing line linear.
/// Holds the lines in hand (at most 16 robots x missions; others wait in obs_pose). Works inside
/// the caller's transaction; after a rollback call Clear().
class Tracks {
 public:
  /// After the pose has been written to obs_pose.
  core::Expected<void> Add(OgrDataset& dataset, const std::string& robot,
                           const std::string& mission, const TrackVertex& vertex);
  /// Writes the lines that have grown enough; `all`: every line that lacks a vertex.
  core::Expected<void> Write(OgrDataset& dataset, bool all);
  void Clear() { tracks_.clear(); }

  /// Lines that do not fit obs_pose (a writer was killed between two of the above) are made anew.
  static core::Expected<void> Mend(OgrDataset& dataset);

 private:
  struct Track {
    std::string robot;
    std::string mission;
    std::vector<TrackVertex> vertices;
    std::size_t unwritten = 0;
    bool corrected = false;  ///< a vertex moved: write soon
  };
  static core::Expected<void> Load(OgrDataset& dataset, Track& track);
  static core::Expected<void> Write(OgrDataset& dataset, Track& track);

  std::list<Track> tracks_;  ///< the one used last is in front
};

}  // namespace kawara::gis
