#include <cstdio>

#include "drivers/v4l2_controls.hpp"
#include "drivers/v4l2_finder.hpp"
#include "tools/camera/camera_commands.hpp"

namespace kawara::tools {

core::Expected<int> CameraControls(const std::string& device_name,
                                   const std::vector<std::string>& settings) {
  const auto parsed = ParseSettings(settings);
  if (!parsed) return tl::unexpected(parsed.error());
  auto chosen = DeviceOf(device_name);
  if (!chosen) return tl::unexpected(chosen.error());
  drivers::V4l2Finder finder(std::move(*chosen), drivers::OpenV4l2Node);
  auto device = finder.Find();
  if (!device) return tl::unexpected(device.error());
  auto controls = drivers::V4l2Controls::Read(*device);
  if (!controls) return tl::unexpected(controls.error());
  if (auto set = controls->Set(*parsed); !set) return tl::unexpected(set.error());
  if (!parsed->empty()) controls = drivers::V4l2Controls::Read(*device);  // automatics may change
  if (!controls) return tl::unexpected(controls.error());
  if (controls->all().empty()) {
    std::printf("%s (%s) has no controls\n", device->path().c_str(),
                device->identity().card.c_str());
  }
  for (const drivers::V4l2Control& control : controls->all()) {
    std::printf("%-32s %s: %s%s%s\n", control.name.c_str(), controls->ValueText(control).c_str(),
                RangeText(control).c_str(), control.read_only() ? " [can only be read]" : "",
                control.inactive() ? " [an automatic has it]" : "");
  }
  return 0;
}

}  // namespace kawara::tools
