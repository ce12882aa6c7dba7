#pragma once
#include <string>
#include <vector>

#include "core/geodesy.hpp"
#include "gis/rtk_colour.hpp"

namespace kawara::gis {

/// What a map shows beside the robots' tracks.
struct MapOverlay {
  struct Outline {
    std::vector<core::Geodetic> ring;  ///< 3 or more, not closed
    Colour colour;
    std::string label;  ///< ASCII
  };
  struct Stroke {
    core::Geodetic from, to;
    Colour colour;
  };
  struct Legend {
    Colour colour;
    std::string text;  ///< ASCII
  };
  std::vector<Stroke> strokes;    ///< below the tracks
  std::vector<Outline> outlines;  ///< above them
  std::vector<Legend> legend;
};

}  // namespace kawara::gis
