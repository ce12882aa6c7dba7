#pragma once
#include <filesystem>
#include <string_view>

#include "core/expected.hpp"

namespace kawara::gis {

/// Puts a file where it belongs, whole and durable, or not at all: written beside its place as
/// ".NAME.tmp", fsync, renamed, its folder fsynced. Errors: kNotFound, kPermission, kFull, kIo.
core::Expected<void> WriteWholeFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace kawara::gis
