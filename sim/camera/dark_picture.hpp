#pragma once
#include "sim/camera/picture_source.hpp"

namespace kawara::sim {

/// What a camera delivers whose shutter stays closed: black with a little noise, of the same size.
/// Errors: kIo (the encoder's).
core::Expected<Picture> DarkPicture(const Picture& instead_of);

}  // namespace kawara::sim
