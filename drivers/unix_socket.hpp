#pragma once
#include <string>

#include "core/expected.hpp"

namespace kawara::drivers {

/// Connects to the UNIX stream socket at `path`; the descriptor is non-blocking, close-on-exec and
/// the caller's. `what` names it in errors ("camera socket"), `who` the program that should be
/// behind it ("the camera's program"). Errors: kInvalidArgument (a path that no socket can have),
/// kUnavailable (nobody there), what errno says of socket(). Never waits.
core::Expected<int> ConnectUnix(const std::string& path, const std::string& what,
                                const std::string& who);

}  // namespace kawara::drivers
