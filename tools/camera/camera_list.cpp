#include <cstdio>

#include "drivers/v4l2_finder.hpp"
#include "tools/camera/camera_commands.hpp"

namespace kawara::tools {
namespace {

void PrintOffers(const drivers::V4l2Device& device) {
  const auto offers = device.Offers();
  if (!offers) {
    std::printf("  %s\n", offers.error().message.c_str());
    return;
  }
  std::string others;
  for (const drivers::V4l2FormatOffer& offer : *offers) {
    if (drivers::FindV4l2PixelFormat(offer.fourcc) == nullptr) {
      others += " " + drivers::FourccText(offer.fourcc);
      continue;
    }
    std::printf("  %s (%s)\n", drivers::FourccText(offer.fourcc).c_str(),
                offer.description.c_str());
    for (const drivers::V4l2SizeOffer& size : offer.sizes) {
      std::printf("    %-12s %s Hz\n", drivers::SizeText(size).c_str(),
                  drivers::RatesText(size).c_str());
    }
  }
  if (!others.empty()) std::printf("  not taken by the robot:%s\n", others.c_str());
}

}  // namespace

core::Expected<int> CameraList() {
  const std::vector<std::string> nodes = drivers::ListVideoNodes();
  if (nodes.empty()) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "no video device in /dev (camera plugged in? `lsusb`, `dmesg` tell whether "
                      "the kernel sees it)");
  }
  int cameras = 0;
  for (const std::string& path : nodes) {
    auto device =
        drivers::OpenV4l2Node(path).and_then([&path](std::unique_ptr<drivers::V4l2Node> node) {
          return drivers::V4l2Device::Take(path, std::move(node));
        });
    if (!device) {
      std::printf("%s\n", device.error().message.c_str());
      continue;
    }
    ++cameras;
    const drivers::V4l2Identity& identity = device->identity();
    std::printf("%s: %s, driver %s, bus %s%s\n", path.c_str(), identity.card.c_str(),
                identity.driver.c_str(), identity.bus_info.c_str(),
                device->multiplanar() ? ", multi-planar" : "");
    for (const std::string& name : drivers::StableNames(path)) std::printf("  %s\n", name.c_str());
    PrintOffers(*device);
  }
  return cameras > 0 ? 0 : 1;
}

}  // namespace kawara::tools
