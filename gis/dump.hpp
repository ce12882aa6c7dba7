#pragma once
#include <filesystem>
#include <ostream>
#include <string>

#include "core/expected.hpp"

namespace kawara::gis {

/// Everything a store says, as text that is equal exactly when two stores are: every row of every
/// layer, one a line, sorted by its key, columns by name, times in UTC, geometry with all digits,
/// and for every picture its size and the CRC-32 computed from the file. Left out: row numbers
/// (fid), which only tell the order of arrival. `pictures_dir` is needed for PostGIS only; empty:
/// "pictures" in the working folder. A picture that is missing or is not what its row says is
/// printed as such and makes the answer kFormat after the whole dump.
core::Expected<void> DumpStore(const std::string& target, const std::filesystem::path& pictures_dir,
                               std::ostream& out);

}  // namespace kawara::gis
