#pragma once
#include <filesystem>

#include "core/expected.hpp"
#include "onboard/changes/change_run.hpp"

namespace kawara::changes {

/// What stands now, for other people's programs, into a folder that is made: changes.geojson,
/// .kmz, .city.json, .wrl, .glb, a Cursor on Target event an object (UID.cot.xml), and the CSV twin
/// of the KIWI+ tables. Errors: those of the files.
core::Expected<void> WriteExports(const ChangeRunOptions& options, const ChangeRunResult& result,
                                  const std::filesystem::path& folder);

}  // namespace kawara::changes
