#include "drivers/v4l2_finder.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>
#include <utility>

namespace kawara::drivers {
namespace {

namespace fs = std::filesystem;

/// The N of /dev/videoN; none: another device.
std::optional<int> NumberOf(const std::string& file) {
  constexpr std::string_view kName = "video";
  if (!file.starts_with(kName)) return std::nullopt;
  int number = 0;
  const char* const end = file.data() + file.size();
  const auto [rest, error] = std::from_chars(file.data() + kName.size(), end, number);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return number;
}

}  // namespace

std::vector<std::string> ListVideoNodes() {
  std::vector<std::pair<int, std::string>> found;
  std::error_code error;
  for (fs::directory_iterator it("/dev", error), end; !error && it != end; it.increment(error)) {
    if (const auto number = NumberOf(it->path().filename().string())) {
      found.emplace_back(*number, it->path().string());
    }
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> nodes;
  nodes.reserve(found.size());
  for (auto& [number, path] : found) nodes.push_back(std::move(path));
  return nodes;
}

std::vector<std::string> StableNames(const std::string& node) {
  std::vector<std::string> names;
  for (const char* const folder : {"/dev/v4l/by-id", "/dev/v4l/by-path"}) {
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      std::error_code broken;
      if (fs::canonical(it->path(), broken) == fs::path(node)) names.push_back(it->path().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

V4l2Finder::V4l2Finder(std::string device, V4l2Opener opener, Lister nodes)
    : device_(std::move(device)), opener_(std::move(opener)), nodes_(std::move(nodes)) {}

core::Expected<V4l2Device> V4l2Finder::Open(const std::string& path) const {
  auto node = opener_(path);
  if (!node) return tl::unexpected(node.error());
  return V4l2Device::Take(path, std::move(*node));
}

std::optional<V4l2Device> V4l2Finder::Search(
    const std::function<bool(const V4l2Identity&)>& fits) const {
  for (const std::string& path : nodes_()) {
    auto device = Open(path);
    if (device && fits(device->identity())) return std::move(*device);
  }
  return std::nullopt;
}

core::Expected<V4l2Device> V4l2Finder::Find() {
  auto device = device_.starts_with('/') ? ByPath() : ByIdentity();
  if (device && !known_) known_ = device->identity();
  return device;
}

core::Expected<V4l2Device> V4l2Finder::ByPath() {
  auto device = Open(device_);
  if (!known_ || (device && device->identity() == *known_)) return device;
  if (auto moved = Search([this](const V4l2Identity& other) { return other == *known_; })) {
    return std::move(*moved);
  }
  if (!device || device->identity().card == known_->card) return device;
  return core::Fail(core::ErrorCode::kUnavailable,
                    "camera " + device_ + ": " + known_->card + " (" + known_->bus_info +
                        ") is gone and " + device->identity().card + " (" +
                        device->identity().bus_info +
                        ") is in its place (give a link of /dev/v4l/by-id as the device)");
}

core::Expected<V4l2Device> V4l2Finder::ByIdentity() {
  if (known_) {
    if (auto same = Search([this](const V4l2Identity& other) { return other == *known_; })) {
      return std::move(*same);
    }
  }
  auto named = Search([this](const V4l2Identity& other) {
    return other.bus_info == device_ || other.card == device_;
  });
  if (named) return std::move(*named);
  return core::Fail(core::ErrorCode::kUnavailable,
                    "camera " + device_ +
                        ": no capture device of this bus or name (plugged in? `kawara-camera list` "
                        "shows what is there)");
}

}  // namespace kawara::drivers
