#include "comms/log_files.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>

#include "comms/event_log.hpp"
#include "comms/log_file_source.hpp"

namespace kawara::comms {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kSuffix = ".lcmlog";
constexpr std::array<std::string_view, 2> kContents{"navigation", "pictures"};
// A file that has no event in here is not a damaged log but something else.
constexpr std::uint64_t kLookForFirstEventBytes = 16 << 20;

bool StartsWithEvent(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 4> start{};
  return file.read(start.data(), start.size()) &&
         start == std::array<char, 4>{'\xED', '\xA1', '\xDA', '\x01'};
}

core::Expected<void> CheckIsLog(const fs::path& path) {
  auto source = LogFileSource::Open(path);
  if (!source) return tl::unexpected(std::move(source.error()));
  if (source->size() == 0 || !SegmentContent(path).empty())
    return {};  // nothing was written, or all was lost
  const std::uint64_t first = source->Find(kLogSync, 0, 0, kLookForFirstEventBytes);
  if (first < std::min(source->size(), kLookForFirstEventBytes)) return {};
  return core::Fail(core::ErrorCode::kFormat, path.string() + ": not an LCM log (no event in it)");
}

core::Expected<void> AddFolder(const fs::path& folder, std::vector<fs::path>& files) {
  std::error_code error;
  std::vector<fs::path> found;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (!fs::is_regular_file(entry->symlink_status(ignored))) continue;
    if (entry->path().extension() == kSuffix || StartsWithEvent(entry->path()))
      found.push_back(entry->path());
  }
  if (error)
    return tl::unexpected(core::ErrnoError("read folder " + folder.string(), error.value()));
  if (found.empty()) {
    return core::Fail(core::ErrorCode::kNotFound, folder.string() + ": no LCM log in this folder");
  }
  std::ranges::sort(found);
  files.insert(files.end(), found.begin(), found.end());
  return {};
}

}  // namespace

std::string SegmentName(std::string_view content, std::uint32_t index) {
  std::array<char, 16> number{};
  std::snprintf(number.data(), number.size(), "-%06u", index);
  return std::string(content) + number.data() + std::string(kSuffix);
}

std::string SegmentContent(const fs::path& path) {
  const std::string name = path.filename().string();
  for (const std::string_view content : kContents) {
    const std::size_t digits_at = content.size() + 1;
    if (!name.starts_with(std::string(content) + "-") || !name.ends_with(kSuffix)) continue;
    const std::string digits = name.substr(digits_at, name.size() - digits_at - kSuffix.size());
    const bool numeric = digits.find_first_not_of("0123456789") == std::string::npos;
    if (digits.size() >= 6 && numeric) return std::string(content);
  }
  return {};
}

core::Expected<std::vector<LogRecording>> FindLogs(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::is_directory(status)) {
      if (auto ok = AddFolder(path, files); !ok) return tl::unexpected(std::move(ok.error()));
    } else {
      if (auto ok = CheckIsLog(path); !ok) return tl::unexpected(std::move(ok.error()));
      files.push_back(path);
    }
  }

  std::vector<LogRecording> recordings;
  std::map<fs::path, std::map<std::string, LogChain>> missions;  // folder, content
  std::set<fs::path> seen;
  for (const fs::path& file : files) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(file, error);
    if (!seen.insert(canonical).second) continue;  // named twice
    const std::string content = SegmentContent(file);
    if (content.empty()) {
      recordings.push_back({false, {{{file}}}});
    } else {
      missions[canonical.parent_path()][content].files.push_back(file);
    }
  }
  for (auto& [folder, chains] : missions) {
    LogRecording recording;
    recording.by_recorder = true;
    for (auto& [content, chain] : chains) {
      std::ranges::sort(chain.files, {}, [](const fs::path& path) { return path.filename(); });
      recording.chains.push_back(std::move(chain));
    }
    recordings.push_back(std::move(recording));
  }
  return recordings;
}

}  // namespace kawara::comms
