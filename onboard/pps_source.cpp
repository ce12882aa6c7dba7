#include "onboard/pps_source.hpp"

#include "drivers/pps_device.hpp"
#include "drivers/pps_socket_client.hpp"

namespace kawara::onboard {

std::unique_ptr<drivers::PpsSource> MakePps(const PpsSettings& settings) {
  if (!settings.device.starts_with("/dev/")) {
    return std::make_unique<drivers::SocketPps>(settings.device);
  }
  const auto edge =
      settings.edge == "falling" ? drivers::PulseEdge::kFalling : drivers::PulseEdge::kRising;
  return std::make_unique<drivers::KernelPps>(settings.device, edge);
}

}  // namespace kawara::onboard
