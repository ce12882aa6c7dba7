#pragma once
#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/object_textures.hpp"

/// What a register may hold. Objects come over a radio, too: nothing in them is believed.
/// kInvalidArgument with the object's name and the first thing that is wrong.
namespace kawara::gis {

/// Uid 1..64 of [A-Za-z0-9._-] and not beginning with a dot; revision from 1; finite box with a
/// volume; symmetric covariance with no negative variance; probabilities 0..1; times 2000..2200 in
/// their order; `gone` set if and only if the state is kGone; robots: clean names, no comma, each
/// once.
core::Expected<void> CheckObject(const core::ChangedObject& object);
/// Named road, finite figures, edges apart, unknown share 0..1.
core::Expected<void> CheckStation(const core::RoadStation& station);
/// No atlas and no faces, or a whole JPEG of the stated size, every side at most once and inside.
core::Expected<void> CheckTextures(const core::ObjectTextures& textures);

}  // namespace kawara::gis
