#pragma once
#include <array>
#include <cstdint>

#include "core/measurements.hpp"

namespace kawara::gis {

struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
};

struct RtkColour {
  core::RtkState state;
  Colour colour;
};

/// How every map of ours shows trust in a position: green may be measured on, red may not.
inline constexpr std::array<RtkColour, 6> kRtkColours{{
    {core::RtkState::kFixed, {26, 152, 80}},
    {core::RtkState::kFloat, {253, 174, 97}},
    {core::RtkState::kCodeDifferential, {244, 109, 67}},
    {core::RtkState::kAutonomous, {215, 48, 39}},
    {core::RtkState::kDeadReckoning, {128, 90, 160}},
    {core::RtkState::kNone, {130, 130, 130}},
}};

}  // namespace kawara::gis
