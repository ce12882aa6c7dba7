#pragma once
#include <filesystem>
#include <string_view>

#include "core/expected.hpp"

namespace kawara::sim {

/// A non-blocking UNIX stream socket that listens at `path`; a dead socket of that name is
/// replaced. `what` names it in errors ("camera"): kInvalidArgument for a path that is too long,
/// kIo and others from the system. The caller closes it and removes the file.
core::Expected<int> ListenUnix(const std::filesystem::path& path, std::string_view what);

}  // namespace kawara::sim
