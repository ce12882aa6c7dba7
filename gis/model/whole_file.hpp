#pragma once
#include <filesystem>
#include <string_view>

#include "core/expected.hpp"

namespace kawara::gis {

/// Puts a file where it belongs, whole and durable, or not at all: written beside its place as
/// ".NAME.tmp", fsync, renamed, its folder fsynced. Errors: kNotFound, kPermission, kFull, kIo.
core::Expected<void> WriteWholeFile(const std::filesystem::path& path, std::string_view bytes);

/// Whether that would work now, before work is done for it: makes the folder if there is none, and
/// takes the file's place beside it for a moment. Errors: as above; kInvalidArgument: the path is a
/// folder.
core::Expected<void> CheckWritable(const std::filesystem::path& path);

}  // namespace kawara::gis
