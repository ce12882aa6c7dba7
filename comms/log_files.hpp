#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::comms {

/// The recorder's names: "navigation-000000.lcmlog", "pictures-000000.lcmlog".
std::string SegmentName(std::string_view content, std::uint32_t index);
/// "navigation" or "pictures" if the file is called so; else empty.
std::string SegmentContent(const std::filesystem::path& path);

/// Files that follow one another: the segments of one content of one recording, or one foreign log.
struct LogChain {
  std::vector<std::filesystem::path> files;
};
/// What is numbered through: the chains of one mission's folder, or one foreign log.
struct LogRecording {
  bool by_recorder = false;
  std::vector<LogChain> chains;
};

/// Sorts out what the user named: files as they are, folders with all logs in them and below.
/// Errors: kNotFound (nothing there, or no log in a folder), kPermission, kFormat (a file that is
/// no log).
[[nodiscard]] core::Expected<std::vector<LogRecording>> FindLogs(
    const std::vector<std::filesystem::path>& paths);

}  // namespace kawara::comms
