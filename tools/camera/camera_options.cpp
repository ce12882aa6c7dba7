#include <charconv>
#include <system_error>

#include "drivers/v4l2_finder.hpp"
#include "tools/camera/camera_commands.hpp"

namespace kawara::tools {
namespace {

bool ParseSize(const std::string& text, drivers::V4l2ModeWish& wish) {
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, wish.width_px);
  if (width.ec != std::errc{} || width.ptr == end || *width.ptr != 'x') return false;
  const auto height = std::from_chars(width.ptr + 1, end, wish.height_px);
  return height.ec == std::errc{} && height.ptr == end && wish.width_px > 0 && wish.height_px > 0;
}

}  // namespace

core::Expected<std::string> DeviceOf(const std::string& device) {
  if (!device.empty()) return device;
  std::string found, all;
  int count = 0;
  for (const std::string& path : drivers::ListVideoNodes()) {
    auto node = drivers::OpenV4l2Node(path);
    if (!node) {
      if (node.error().code == core::ErrorCode::kPermission) return tl::unexpected(node.error());
      continue;
    }
    if (!drivers::V4l2Device::Take(path, std::move(*node))) continue;
    found = path;
    all += " " + path;
    ++count;
  }
  if (count == 1) return found;
  return core::Fail(core::ErrorCode::kNotFound,
                    count == 0
                        ? "no camera found (plugged in? `kawara-camera list` shows what is there)"
                        : "several cameras:" + all + "; say which with --device");
}

core::Expected<drivers::V4l2Settings> ParseSettings(const std::vector<std::string>& settings) {
  drivers::V4l2Settings parsed;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "\"" + setting + "\": expected NAME=VALUE, as exposure_time_absolute=50");
    }
    parsed.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
  }
  return parsed;
}

core::Expected<drivers::V4l2CameraConfig> ConfigOf(const CameraOptions& options) {
  drivers::V4l2CameraConfig config;
  auto settings = ParseSettings(options.settings);
  if (!settings) return tl::unexpected(settings.error());
  config.controls = std::move(*settings);
  if (!options.size.empty() && !ParseSize(options.size, config.mode)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "--size " + options.size + ": expected WIDTHxHEIGHT, as 1920x1080");
  }
  if (!options.format.empty() && drivers::FindV4l2PixelFormat(options.format) == nullptr) {
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "--format " + options.format + ": expected one of " + drivers::V4l2PixelFormatNames());
  }
  config.mode.format = options.format;
  config.mode.rate_hz = options.rate_hz;
  config.stamps.exposure = core::DurationFromSeconds(options.exposure_s);
  config.stamps.readout = core::DurationFromSeconds(options.readout_s);
  auto device = DeviceOf(options.device);
  if (!device) return tl::unexpected(device.error());
  config.device = std::move(*device);
  return config;
}

}  // namespace kawara::tools
